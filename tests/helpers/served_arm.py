"""The virtual arm in a process of its own."""

import subprocess
import sys

from omx.errors import OmxError


class Served:
    """A virtual arm in another process; `name` is the port for `Bus` or any other program.

    `arguments` are those of `python -m omx.hardware.simulator`, "--tcp" and "0" if there are none. The process
    ends with the `with` block, and with `close`.
    """

    def __init__(self, *arguments: str):
        self._process = subprocess.Popen(
            [sys.executable, "-m", "omx.hardware.simulator", *(arguments or ("--tcp", "0"))],
            stdout=subprocess.PIPE,
            text=True,
        )
        self.name = self._process.stdout.readline().strip()
        if not self.name:
            self.close()
            raise OmxError(f"the virtual arm did not start (exit code {self._process.returncode}).")

    def close(self):
        """End the process."""
        self._process.terminate()
        self._process.stdout.close()
        self._process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()
