"""A real JupyterLab for tests, started as the launcher starts it, and what it listens on and leaves behind."""

import contextlib
import json
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

import psutil

from book.setup import paths

START_TIMEOUT_S = 60


class Lab:
    """A running server: `url`, `token`, `page(notebook)`; `tree()` are all its processes, `listening()` its ports."""

    def __init__(self, folder, root=paths.ROOT):
        self.token, self.port = secrets.token_hex(12), free_port()
        self.url = f"http://127.0.0.1:{self.port}"
        options = ["--no-browser", f"--ServerApp.port={self.port}", "--ServerApp.port_retries=0"]
        options += [f"--IdentityProvider.token={self.token}", f"--ServerApp.root_dir={root}"]
        first = min((root / "notebooks").glob("*.ipynb"))
        settings = {f"JUPYTER_{name}_DIR": str(folder / name.lower()) for name in ("CONFIG", "DATA")}
        settings["JUPYTER_RUNTIME_DIR"] = self.runtime = tempfile.mkdtemp(prefix="omx-")  # short, for sockets
        settings["JUPYTERLAB_SETTINGS_DIR"] = str(folder / "settings")
        settings["JUPYTERLAB_WORKSPACES_DIR"] = str(folder / "workspaces")
        self.log = (folder / "lab.log").open("w+")
        self.process = subprocess.Popen(
            [sys.executable, "-m", "book.reader.lab", "--author", str(first), *options],
            cwd=root,
            env={**paths.child_environment(), **settings},
            stdout=self.log,
            stderr=subprocess.STDOUT,
        )
        self.server = psutil.Process(self.process.pid)

    def wait(self):
        """Until the server answers; with its log when it does not."""
        deadline = time.monotonic() + START_TIMEOUT_S
        while time.monotonic() < deadline and self.process.poll() is None:
            with contextlib.suppress(OSError):
                return self.ask("status")
            time.sleep(0.1)
        self.log.seek(0)
        raise RuntimeError(f"JupyterLab does not answer:\n{self.log.read()}")

    def ask(self, path, body=None, method=None):
        """The answer of the server's REST API, parsed; a body makes it a POST, if no other method is named."""
        request = urllib.request.Request(
            f"{self.url}/api/{path}",
            data=None if body is None else json.dumps(body).encode(),
            headers={"Authorization": f"token {self.token}"},
            method=method,
        )
        with urllib.request.urlopen(request, timeout=30) as answer:
            return json.load(answer)

    def page(self, notebook="notebooks/00-start-here.ipynb"):
        """The address of a notebook in this JupyterLab, for a browser."""
        return f"{self.url}/lab/tree/{notebook}?token={self.token}"

    def tree(self):
        """The server and all processes below it."""
        return [self.server, *self.server.children(recursive=True)]

    def listening(self):
        """The (address, port) pairs on which any of the server's processes listens for TCP."""
        return {tuple(c.laddr) for p in self.tree() for c in p.net_connections("tcp") if c.status == psutil.CONN_LISTEN}

    def stop(self):
        """Ask the server to end, as Ctrl-C twice does; kill what is left, and say what that was."""
        processes = self.tree() if self.process.poll() is None else []
        self.process.terminate()
        left = psutil.wait_procs(processes, timeout=15)[1]
        for process in left:
            process.kill()
        self.process.wait()
        self.log.close()
        shutil.rmtree(self.runtime, ignore_errors=True)
        return left


@contextlib.contextmanager
def running_lab(folder, **more):
    """A JupyterLab for the time of a `with` block."""
    lab = Lab(folder, **more)
    try:
        lab.wait()
        yield lab
    finally:
        lab.stop()


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def run_in_kernel(lab, kernel_id, code, timeout_s=60):
    """Run code in a kernel of the server, through the server as a browser does; the text that it printed."""
    import websocket

    address = lab.url.replace("http", "ws", 1) + f"/api/kernels/{kernel_id}/channels?session_id=t"
    header = [f"Authorization: token {lab.token}"]
    message = {
        "header": {"msg_id": secrets.token_hex(8), "msg_type": "execute_request", "session": "t", "username": "t"},
        "parent_header": {},
        "metadata": {},
        "channel": "shell",
        "content": {"code": code, "silent": False, "store_history": False, "allow_stdin": False},
    }
    message["header"].update(version="5.3", date="")
    printed, missing = [], {"execute_reply", "idle"}  # on two channels, in no fixed order
    with contextlib.closing(websocket.create_connection(address, timeout=timeout_s, header=header)) as line:
        line.send(json.dumps(message))
        while missing:
            answer = line.recv()
            answer = json.loads(answer) if isinstance(answer, str) else {}  # a widget's buffers come as bytes
            if answer.get("parent_header", {}).get("msg_id") != message["header"]["msg_id"]:
                continue
            if answer["msg_type"] == "error":
                raise RuntimeError("\n".join(answer["content"]["traceback"]))
            if answer["msg_type"] == "stream":
                printed.append(answer["content"]["text"])
            missing -= {answer["msg_type"], answer["content"].get("execution_state")}
    return "".join(printed)
