"""A JupyterHub for tests: the book's settings, a login that lets everybody in, and a folder in /tmp for each user."""

import contextlib
import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import psutil
import requests

from book.publish import npm
from book.setup import extra_envs
from book.setup.paths import ROOT, WINDOWS, Stop
from tests.helpers.lab import free_port

SETTINGS = ROOT / ".devcontainer" / "jupyterhub_config.py"
START_TIMEOUT_S = 90

#: What a class's administrator adds to the book's settings; here for a test on one machine, under one account.
ADDED = """
load_subconfig({settings!r})
c.JupyterHub.bind_url = "http://127.0.0.1:{port}"
c.JupyterHub.hub_port = {hub_port}
c.JupyterHub.authenticator_class = "dummy"
c.Authenticator.allow_all = True
c.JupyterHub.spawner_class = "simple"
c.Spawner.args.extend({flags!r})
c.SimpleLocalProcessSpawner.home_dir_template = {homes!r} + "/{{username}}"
c.JupyterHub.db_url = "sqlite:///:memory:"
c.JupyterHub.cookie_secret = bytes(range(32))
c.ConfigurableHTTPProxy.command = {proxy!r}
c.ConfigurableHTTPProxy.api_url = "http://127.0.0.1:{proxy_port}"
"""


class Hub:
    """A running hub: `login(name)` gives a `User`; `tree()` are all its processes, `listening()` their addresses."""

    def __init__(self):
        proxy, python = proxy_command(), extra_envs.python("hub")
        self.folder = Path(tempfile.mkdtemp(prefix="omx-"))  # short: the path of a socket has 107 characters at most
        self.ports = {name: free_port() for name in ("port", "hub_port", "proxy_port")}
        self.url = f"http://127.0.0.1:{self.ports['port']}"
        places = {"settings": str(SETTINGS), "homes": str(self.folder), "proxy": proxy, **self.ports}
        flags = ["--allow-root"] if os.geteuid() == 0 else []
        (self.folder / "config.py").write_text(ADDED.format(**places, flags=flags), encoding="utf-8")
        self.log = (self.folder / "hub.log").open("w+")
        command = [python, "-m", "jupyterhub", "-f", self.folder / "config.py"]
        self.process = subprocess.Popen(
            command, cwd=self.folder, env=extra_envs.variables("hub"), stdout=self.log, stderr=subprocess.STDOUT
        )
        self.server = psutil.Process(self.process.pid)

    def wait(self):
        """Until the hub answers; with its log when it does not."""
        deadline = time.monotonic() + START_TIMEOUT_S
        while time.monotonic() < deadline and self.process.poll() is None:
            with contextlib.suppress(requests.RequestException):
                if requests.get(f"{self.url}/hub/health", timeout=5).ok:
                    return
            time.sleep(0.1)
        raise RuntimeError(f"JupyterHub does not answer:\n{self.said()}")

    def said(self):
        self.log.seek(0)
        return self.log.read()

    def home(self, name):
        """Put a copy of the book into a user's home."""
        shutil.copytree(ROOT / "omx", self.folder / name / "omx", ignore=shutil.ignore_patterns("__pycache__"))

    def login(self, name):
        """Log in by the form, as a browser does, with a copy of the book at home; the user's server runs then."""
        self.home(name)
        return User(self, name)

    def tree(self):
        """The hub, its proxy, the users' servers and their kernels."""
        return [self.server, *self.server.children(recursive=True)]

    def listening(self):
        """For each process that listens for TCP: its id and its addresses."""
        found = {p.pid: [c.laddr for c in p.net_connections("tcp") if c.status == "LISTEN"] for p in self.tree()}
        return {pid: addresses for pid, addresses in found.items() if addresses}

    def stop(self):
        """End the hub as a service manager does; kill what is left after that, and say what that was."""
        processes = self.tree() if self.process.poll() is None else []
        self.process.terminate()
        left = psutil.wait_procs(processes, timeout=30)[1]
        for process in left:
            process.kill()
        self.process.wait()
        self.log.close()
        shutil.rmtree(self.folder, ignore_errors=True)
        return left


class User:
    """Somebody who logged in: `url` and `token` of a server of their own, as `lab.run_in_kernel` wants them."""

    def __init__(self, hub, name):
        self.hub, self.name, self.url = hub, name, f"{hub.url}/user/{name}"
        self._session = requests.Session()
        self._session.get(f"{hub.url}/hub/login", timeout=30).raise_for_status()
        form = {"username": name, "password": "any", "_xsrf": self._session.cookies.get("_xsrf", path="/hub/")}
        self._session.post(f"{hub.url}/hub/login", data=form, timeout=30).raise_for_status()
        self.token = self._hub("POST", f"users/{name}/tokens")["token"]

    def _hub(self, method, path):
        headers = {"X-XSRFToken": self._session.cookies.get("_xsrf", path="/hub/")}
        answer = self._session.request(method, f"{self.hub.url}/hub/api/{path}", headers=headers, timeout=60)
        answer.raise_for_status()
        return answer.json() if answer.content else None

    def start(self):
        """Start this user's server and wait until it runs."""
        with contextlib.suppress(requests.HTTPError):  # the login has started it already
            self._hub("POST", f"users/{self.name}/server")
        deadline = time.monotonic() + START_TIMEOUT_S
        while not (self._hub("GET", f"users/{self.name}")["servers"].get("", {}).get("ready")):
            if time.monotonic() > deadline:
                raise RuntimeError(f"the server of {self.name} does not start:\n{self.hub.said()}")
            time.sleep(0.2)
        return self

    def ask(self, path, body=None):
        """The status and the answer of this user's server; a body makes it a POST."""
        return ask(self.url, self.token, path, body)

    def kernel(self):
        """The id of a new kernel."""
        return self.ask("kernels", {"name": "python3"})[1]["id"]


def ask(url, token, path, body=None):
    headers = {"Authorization": f"token {token}"}
    data = None if body is None else json.dumps(body)
    answer = requests.request("GET" if body is None else "POST", f"{url}/api/{path}", data=data, headers=headers,
                              timeout=60)  # fmt: skip
    return answer.status_code, answer.json()


def proxy_command():
    """The command of JupyterHub's proxy, which comes from npm. Raises `Stop`."""
    if WINDOWS:
        raise Stop("JupyterHub does not run on Windows.")
    folder = npm.modules(ROOT / "book" / "hub", ROOT / "build" / "npm-hub")
    return [shutil.which("node"), str(folder / "configurable-http-proxy" / "bin" / "configurable-http-proxy")]


@contextlib.contextmanager
def running_hub():
    """A JupyterHub for the time of a `with` block. Raises `Stop` where it cannot be had."""
    hub = Hub()
    try:
        hub.wait()
        yield hub
    finally:
        hub.stop()
