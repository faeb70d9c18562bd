"""Kernels that talk over Unix sockets instead of TCP ports, where there are some.

Several kernels that start at once now and then draw the same TCP port; sockets in a folder of their own
cannot collide, and nobody else on the machine can reach them.
"""

import os
import shutil
import sys
import tempfile
import weakref
from pathlib import Path

from jupyter_client.manager import AsyncKernelManager, KernelManager


class OnSockets:
    """Mix-in for a kernel manager: Unix sockets in a folder that goes with the kernel; Linux only."""

    folder = None

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        os.environ.setdefault("OMX_STUDENT", "")  # the book's own runs have the book's numbers
        if sys.platform == "linux":
            self.folder = tempfile.mkdtemp(prefix="omx-")
            weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)
            self.transport = "ipc"
            self.connection_file = str(Path(self.folder, "k.json"))  # short: a socket's path holds 108 bytes
            self.ip = str(Path(self.folder, "k"))

    async def _async_cleanup_resources(self, restart=False):
        await super()._async_cleanup_resources(restart)
        if self.folder and not restart:
            shutil.rmtree(self.folder, ignore_errors=True)


class SocketKernelManager(OnSockets, AsyncKernelManager):
    """nbclient's kernel manager."""


class BlockingSocketKernelManager(OnSockets, KernelManager):
    """nbval's kernel manager."""
