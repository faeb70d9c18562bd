"""The virtual arm in a process of its own."""

import subprocess
import sys

from omx.errors import BadInput, OmxError


class Served:
    """A virtual arm in another process; `name` is the port for `Bus` or any other program.

    `arguments` are those of `python -m omx.hardware.simulator`, "--tcp" and "0" if there are none. The process
    ends with the `with` block, with `close`, and with this program, however that ends.
    """

    def __init__(self, *arguments: str):
        self._process = subprocess.Popen(
            [sys.executable, "-m", "omx.hardware.simulator", "--stdin", *(arguments or ("--tcp", "0"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.name = self._process.stdout.readline().strip()
        if not self.name:
            self.close()
            raise OmxError(f"the virtual arm did not start (exit code {self._process.returncode}).")

    @property
    def running(self) -> bool:
        """False once the process has ended."""
        return self._process.poll() is None

    def tell(self, order: str):
        """Give an order: a fault such as `lost servo=13 count=2`, or `clear`."""
        self._process.stdin.write(order + "\n")
        self._process.stdin.flush()
        said = self._process.stdout.readline().strip()
        if said != "ok":
            raise BadInput(said or "the virtual arm has ended.")

    def close(self):
        """End the process."""
        self._process.stdin.close()
        self._process.stdout.close()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()
