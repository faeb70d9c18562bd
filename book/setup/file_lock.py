"""Let one process at a time do what must not be done twice at once. Standard library only."""

import contextlib
import errno
import os
import time

from book.setup.paths import WINDOWS


@contextlib.contextmanager
def one_at_a_time(path, waiting=""):
    """Hold the lock of a file that is there, so no lock file is left and a lock dies with its holder.

    `waiting` is told when another process holds it.
    """
    with open(path, "r+b" if os.access(path, os.W_OK) else "rb") as file:
        if waiting and not locked(file):
            print(waiting, flush=True)
        while not locked(file):
            time.sleep(0.3)
        yield file


def locked(file):
    """Try to lock the open file; True also where the file system knows no locks."""
    try:
        if WINDOWS:
            import msvcrt

            file.seek(2**30)  # far behind the text, which others may go on reading
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
    return True
