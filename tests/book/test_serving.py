"""The files for services parse, say what the page `Where it runs` promises, and repeat no version."""

import json
import re
import runpy
from types import SimpleNamespace

import pytest

from book.setup import extra_envs
from book.setup.paths import ROOT, Stop


class Config(SimpleNamespace):
    """What JupyterHub's get_config() gives: sections that take any name."""

    def __getattr__(self, name):
        setattr(self, name, Config())
        return self.__dict__[name]


@pytest.fixture
def hub():
    config = Config()
    runpy.run_path(str(ROOT / ".devcontainer" / "jupyterhub_config.py"), {"get_config": lambda: config})
    return config


def test_the_hub_listens_on_the_loopback_address_only(hub):
    assert hub.JupyterHub.bind_url.startswith("http://127.0.0.1:")
    assert hub.JupyterHub.hub_ip == "127.0.0.1"


def test_the_hub_limits_and_culls_and_uses_sockets(hub):
    assert "--KernelManager.transport=ipc" in hub.Spawner.args
    assert any("cull_idle_timeout" in argument for argument in hub.Spawner.args)
    assert hub.Spawner.mem_limit == "1G"


def test_the_dev_container_sets_up_by_the_launcher():
    about = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text(encoding="utf-8"))
    assert about["postCreateCommand"].startswith("python run.py ")
    assert re.fullmatch(r"python:3\.\d+-\w+", about["image"])


def test_binder_takes_the_books_own_environment():
    lines = (ROOT / ".binder" / "requirements.txt").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if not line.startswith("#")] == ["-r ../environment.txt"]
    assert (ROOT / ".binder" / "postBuild").stat().st_mode & 0o100


@pytest.mark.parametrize("name", ["lite", "fast", "hub"])
def test_environments_beside_are_pinned(name):
    assert all(re.fullmatch(r"[\w-]+(\[\w+\])?==[\w.]+", requirement) for requirement in extra_envs.requirements(name))


def test_an_environment_that_is_not_listed_is_refused():
    with pytest.raises(Stop, match="no line `#: nothing"):
        extra_envs.requirements("nothing")


def test_every_action_is_pinned_by_its_commit_and_names_its_version():
    used = [line.split("uses:")[1] for path in sorted((ROOT / ".github" / "workflows").glob("*.yml"))
            for line in path.read_text(encoding="utf-8").splitlines() if "uses:" in line]  # fmt: skip
    assert len(used) >= 2
    for action in used:
        assert re.fullmatch(r" [\w-]+/[\w-]+@[0-9a-f]{40}  # v[\d.]+", action), action


def test_the_page_names_a_spawner_that_keeps_the_memory_limit():
    page = (ROOT / "book" / "teach" / "serving.md").read_text(encoding="utf-8")
    for word in ("SystemdSpawner", "`MemoryMax`", "DockerSpawner", "**Not run**", "subdomain_host"):
        assert word in page
