"""A pseudo-terminal that is the other end of a TCP connection, for clients that open serial ports only."""

import contextlib
import os
import select
import socket
import threading
import tty


@contextlib.contextmanager
def pty_to(url):
    """The name of a pseudo-terminal whose bytes go to and come from `url` (socket://host:port)."""
    host, port = url.removeprefix("socket://").split(":")
    line = socket.create_connection((host, int(port)), timeout=10)
    master, slave = os.openpty()
    tty.setraw(slave)
    stop, stopper = socket.socketpair()

    def carry():
        while True:
            ready = select.select([line, master, stop], [], [])[0]
            if stop in ready:
                return
            if line in ready:
                os.write(master, line.recv(4096))
            if master in ready:
                line.sendall(os.read(master, 4096))

    thread = threading.Thread(target=carry)
    thread.start()
    try:
        yield os.ttyname(slave)
    finally:
        stopper.send(b"!")
        thread.join(10)
        for end in (line, stop, stopper):
            end.close()
        os.close(master)
        os.close(slave)
