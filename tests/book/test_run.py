"""The launcher, tried on copies of itself with an environment of one tiny package, without any network."""

import ast
import errno
import hashlib
import importlib
import importlib.util
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

from book.reader import lab
from book.setup import installers, launch, lock, names, paths, settings, update
from book.setup.paths import ROOT

UV = shutil.which("uv", path=str(Path(sys.executable).parent)) or shutil.which("uv")


def wheel(folder, name, version, files):
    """A wheel, as small as one can be, that both uv and pip install."""
    info = f"{name}-{version}.dist-info"
    files = {
        **files,
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nGenerator: tests\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    record = "".join(f"{path},sha256={digest(text)},{len(text)}\n" for path, text in files.items())
    with zipfile.ZipFile(folder / f"{name}-{version}-py3-none-any.whl", "w") as archive:
        for path, text in {**files, f"{info}/RECORD": record + f"{info}/RECORD,,\n"}.items():
            archive.writestr(path, text)


def digest(text):
    import base64

    return base64.urlsafe_b64encode(hashlib.sha256(text.encode()).digest()).rstrip(b"=").decode()


class Clone:
    """A copy of the launcher with a `tests/` whose `pytest` is the tiny package; no index, no uv on the PATH."""

    def __init__(self, folder):
        self.root, self.wheels = folder / "a book", folder / "wheels"
        self.wheels.mkdir()
        shutil.copytree(ROOT / "book" / "setup", self.root / "book" / "setup", ignore=shutil.ignore_patterns("__*__"))
        for name in ("run.py", "book/__init__.py"):
            shutil.copy(ROOT / name, self.root / name)
        (self.root / "tests").mkdir()
        (self.root / "omx").mkdir()
        (self.root / "omx" / "__init__.py").write_text("WHERE = __file__\n")
        self.package("1.0")
        self.stub_uv(f"import subprocess, sys; print('stub'); sys.exit(subprocess.call([{UV!r}, *sys.argv[1:]]))")
        self.pin("1.0")

    def package(self, version, code="import sys; print('tiny pytest', *sys.argv[1:])"):
        wheel(self.wheels, "pytest", version, {"pytest/__init__.py": "", "pytest/__main__.py": code + "\n"})

    def pin(self, version, *more):
        lines = more or [f"pytest=={version}", "uv==0.0.1", "# ---- below"]
        (self.root / "environment.txt").write_text("\n".join(lines) + "\n")

    def stub_uv(self, code):
        """The pinned uv, as a package of one line: what it does is the test's choice."""
        wheel(self.wheels, "uv", "0.0.1", {"uv/__init__.py": "", "uv/__main__.py": code + "\n"})

    def environment(self, uv=True, **more):
        folder = Path(UV).parent if uv else Path("/usr/bin")
        keep = {name: value for name, value in os.environ.items() if not name.startswith(("PIP_", "UV_", "PYTHON"))}
        pip = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(self.wheels), "PIP_CONFIG_FILE": os.devnull}
        own = {"UV_NO_INDEX": "1", "UV_FIND_LINKS": str(self.wheels), "UV_NO_CACHE": "1", "UV_OFFLINE": "1"}
        own["UV_NO_CONFIG"] = "1"
        path = {"PATH": os.pathsep.join([str(folder), "/usr/bin", "/bin"]) if uv else str(self.root / "nothing")}
        return {**keep, **pip, **own, **path, "HOME": str(self.root.parent), **more}

    def run(self, *arguments, before="", **environment):
        """`python run.py ...` with a line of Python run before it; the finished process."""
        command = [base_python(), "-c", f"{before}\nimport runpy, sys\nsys.argv = {['run.py', *arguments]!r}\n"]
        command[-1] += (
            f"sys.path[0] = {str(self.root)!r}\nrunpy.run_path({str(self.root / 'run.py')!r}, run_name='__main__')"
        )
        return subprocess.run(
            command,
            cwd=self.root.parent,
            env=self.environment(**environment),
            capture_output=True,
            text=True,
            timeout=180,
            check=False,
        )

    @property
    def ensurepip(self):
        """A module that takes the place of Python's own, for it lies in the folder from which that is started."""
        return self.root / "ensurepip.py"

    @property
    def python(self):
        return self.root / paths.PYTHON.relative_to(paths.ROOT)

    @property
    def stamp(self):
        return self.root / ".venv" / paths.STAMP.name

    def site_packages(self):
        return next(self.root.glob(".venv/[Ll]ib/**/site-packages"))


def base_python():
    return getattr(sys, "_base_executable", sys.executable)


@pytest.fixture(scope="module")
def pip(tmp_path_factory):
    """An environment that the real `ensurepip` has made, once for all tests."""
    folder = tmp_path_factory.mktemp("pip")
    subprocess.run([base_python(), "-m", "venv", folder], check=True)
    return folder


#: In the place of `ensurepip`: links to what that has made elsewhere.
LINKED_PIP = """
import os, sys
for folder, _, files in os.walk({pip!r}):
    here = os.path.join(sys.prefix, os.path.relpath(folder, {pip!r}))
    os.makedirs(here, exist_ok=True)
    for name in set(files) - set(os.listdir(here)):
        os.link(os.path.join(folder, name), os.path.join(here, name))
"""


@pytest.fixture
def clone(tmp_path, pip):
    """Its `ensurepip` links what the real one has made, which takes two seconds; who tests that one takes it away."""
    if UV is None:
        pytest.skip("uv is not installed")
    clone = Clone(tmp_path)
    clone.ensurepip.write_text(LINKED_PIP.format(pip=str(pip)))
    return clone


def one_sentence(done):
    """The one line on stderr with which a command stopped."""
    assert done.returncode not in (0, None), done.stdout
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("run.py: ")
    return lines[0]


# ---- set-up --------------------------------------------------------------------------------------------


def test_first_run_sets_up_later_runs_only_run(clone):
    first = clone.run("test", "-x")
    assert first.returncode == 0, first.stderr
    assert first.stdout.splitlines()[-2:] == ["Set-up complete.", "tiny pytest -n 2 -x"]
    assert len(first.stdout.splitlines()) <= 6
    second = clone.run("test")
    assert second.stdout == "tiny pytest -n 2\n"


def test_omx_is_imported_from_any_folder_even_after_moving(clone, tmp_path):
    assert clone.run("test").returncode == 0
    clone.root = clone.root.rename(tmp_path / "moved")
    where = subprocess.run(
        [clone.python, "-c", "import omx; print(omx.WHERE)"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert Path(where.stdout.strip()).samefile(clone.root / "omx" / "__init__.py")
    assert clone.run("test").stdout == "tiny pytest -n 2\n"


def test_a_changed_environment_is_installed(clone):
    assert clone.run("test").returncode == 0
    clone.package("2.0", "print('newer')")
    clone.pin("2.0")
    done = clone.run("test")
    assert done.stdout.splitlines()[-1] == "newer"
    assert "environment.txt has changed" in done.stdout


def test_without_uv_on_the_path_the_pinned_one_is_used(clone):
    done = clone.run("test", uv=False)
    assert done.stdout.splitlines()[-1] == "tiny pytest -n 2", done.stdout + done.stderr
    assert "stub" in (clone.root / ".venv" / "set-up.log").read_text()


def test_without_any_working_uv_pip_does_it(clone):
    clone.ensurepip.unlink()
    clone.stub_uv("import sys; sys.exit('no wheels for this machine')")
    done = clone.run("test", uv=False)
    assert done.stdout.splitlines()[-1] == "tiny pytest -n 2", done.stdout + done.stderr
    assert "uv could not: no wheels for this machine" in done.stdout


def test_a_venv_without_stamp_is_completed_not_rebuilt(clone):
    assert clone.run("test").returncode == 0
    clone.stamp.unlink()
    (clone.root / ".venv" / "mine").touch()
    shutil.rmtree(clone.site_packages() / "pytest")
    shutil.rmtree(next(clone.site_packages().glob("pytest-*")))
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest -n 2"
    assert (clone.root / ".venv" / "mine").exists()


def test_a_package_that_lost_files_is_noticed_and_all_is_built_anew(clone):
    assert clone.run("test").returncode == 0
    clone.stamp.unlink()
    (clone.root / ".venv" / "mine").touch()
    (clone.site_packages() / "pytest" / "__main__.py").write_text("half")
    done = clone.run("test")
    assert "Some of its packages are not whole: pytest" in done.stdout
    assert done.stdout.splitlines()[-1] == "tiny pytest -n 2"
    assert not (clone.root / ".venv" / "mine").exists()


@pytest.mark.parametrize("debris", ["file", "broken link", "empty folder", "no interpreter", "stamp"])
def test_debris_is_replaced(clone, debris):
    venv = clone.root / ".venv"
    if debris == "file":
        venv.write_text("")
    elif debris == "broken link":
        venv.symlink_to("nowhere", target_is_directory=True)
    else:
        (venv / "bin").mkdir(parents=True)
    if debris == "no interpreter":
        (venv / "bin" / "python").symlink_to("gone")
        (venv / "pyvenv.cfg").write_text("home = nowhere\n")
    if debris == "stamp":
        (clone.stamp / "a folder").mkdir(parents=True)
        clone.stamp.with_suffix(".part").mkdir()
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest -n 2"


def test_a_link_to_another_disk_stays(clone, tmp_path):
    venv = clone.root / ".venv"
    (tmp_path / "big disk" / "old").mkdir(parents=True)
    venv.symlink_to(tmp_path / "big disk", target_is_directory=True)
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest -n 2"
    assert venv.is_symlink()
    assert not (tmp_path / "big disk" / "old").exists()
    where = [clone.python, "-c", "import omx; print(omx.WHERE)"]
    done = subprocess.run(where, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert Path(done.stdout.strip()).samefile(clone.root / "omx" / "__init__.py")


def stopped_by(clone, stop):
    """Start a set-up whose pinned uv hangs, send its process group a signal as soon as uv is there; (status, said)."""
    clone.stub_uv("import sys, time; time.sleep(60 if 'pip' in sys.argv else 0)")
    command = [base_python(), str(clone.root / "run.py"), "test"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, env=clone.environment(uv=False), start_new_session=True, **pipes) as process:
        deadline = time.monotonic() + 60
        while not list(clone.root.glob(".venv/[Ll]ib/**/uv/__main__.py")) and time.monotonic() < deadline:
            time.sleep(0.1)
        time.sleep(0.7)
        os.killpg(process.pid, stop)
        said = process.communicate(timeout=30)[1]
    assert (clone.root / ".venv").exists()
    assert not clone.stamp.exists()
    return process.returncode, said


@pytest.mark.skipif(paths.WINDOWS, reason="signals to process groups are POSIX")
def test_a_killed_set_up_is_taken_up(clone):
    status, _ = stopped_by(clone, signal.SIGKILL)
    assert status == -signal.SIGKILL
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest -n 2"


@pytest.mark.skipif(paths.WINDOWS, reason="signals to process groups are POSIX")
def test_a_closed_terminal_leaves_nothing_half_done(clone):
    assert stopped_by(clone, signal.SIGHUP)[0] == -signal.SIGHUP
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest -n 2"


@pytest.mark.skipif(paths.WINDOWS, reason="signals to process groups are POSIX")
def test_ctrl_c_says_how_to_go_on(clone):
    status, said = stopped_by(clone, signal.SIGINT)
    assert status == 130
    assert said.strip() == "run.py: Interrupted; the same command takes it up again."
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest -n 2"


#: At so many random moments a set-up is interrupted; `OMX_INTERRUPTS=20` asks for more.
MOMENTS = int(os.environ.get("OMX_INTERRUPTS", "2"))
STOPS = ("SIGKILL", "SIGTERM", "SIGHUP", "SIGINT", "SIGKILL of the parent alone")


@pytest.mark.skipif(paths.WINDOWS, reason="signals to process groups are POSIX")
@pytest.mark.parametrize("seed", range(MOMENTS))
def test_a_set_up_stopped_at_any_moment_is_never_called_complete_and_is_taken_up(clone, seed):
    stop, moment = STOPS[seed % len(STOPS)], random.Random(seed).uniform(0.1, 3.0)
    command = [base_python(), str(clone.root / "run.py"), "test"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(command, env=clone.environment(), start_new_session=True, **quiet) as process:
        try:
            process.wait(timeout=moment)
        except subprocess.TimeoutExpired:
            send = os.kill if "alone" in stop else os.killpg
            send(process.pid, getattr(signal, stop.split()[0]))
    if clone.stamp.exists():
        done = subprocess.run([clone.python, "-c", "import omx, pytest"], cwd=clone.root.parent, check=False)
        assert done.returncode == 0
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest -n 2"


def test_two_first_runs_wait_for_each_other(clone):
    commands = [[base_python(), str(clone.root / "run.py"), "test"] for _ in range(2)]
    pair = [
        subprocess.Popen(command, env=clone.environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for command in commands
    ]
    said = [process.communicate(timeout=120) for process in pair]
    assert [process.returncode for process in pair] == [0, 0], said
    assert sorted("Set-up complete." in out for out, _ in said) == [False, True]
    assert all(out.splitlines()[-1] == "tiny pytest -n 2" for out, _ in said)


# ---- a hostile machine ---------------------------------------------------------------------------------

#: Settings for other work, which must neither stop nor mislead a set-up; the tiny package must land in .venv.
FOREIGN = {
    "PIP_USER": "1",
    "PIP_TARGET": "{folder}/elsewhere",
    "PIP_PREFIX": "{folder}/elsewhere",
    "PIP_ROOT": "{folder}/elsewhere",
    "PIP_REQUIRE_HASHES": "1",
    "PIP_REQUIRE_VIRTUALENV": "0",
    "PIP_CONSTRAINT": "{folder}/no such file",
    "PIP_REQUIREMENT": "{folder}/no such file",
    "PIP_NO_BINARY": ":all:",
    "PIP_DRY_RUN": "1",
    "PIP_PYTHON": "/no/python",
    "PIP_LOG": "/no/folder/log",
    "PIP_CONFIG_FILE": "{folder}/.config/pip/pip.conf",
    "UV_TARGET": "{folder}/elsewhere",
    "UV_PREFIX": "{folder}/elsewhere",
    "UV_EXCLUDE_NEWER": "2001-01-01",
    "UV_REQUIRE_HASHES": "1",
    "UV_NO_BINARY": "1",
    "UV_CONSTRAINT": "{folder}/no such file",
    "UV_OVERRIDE": "{folder}/no such file",
    "UV_PYTHON": "2.7",
    "UV_SYSTEM_PYTHON": "1",
    "UV_BREAK_SYSTEM_PACKAGES": "1",
    "UV_CONFIG_FILE": "{folder}/uv.toml",
    "VIRTUAL_ENV": "/no/environment",
    "CONDA_PREFIX": "/no/environment",
    "PYTHONPATH": "{folder}/elsewhere",
    "PYTHONSAFEPATH": "1",
    "PYTHONOPTIMIZE": "2",
    "PYTHONDONTWRITEBYTECODE": "1",
    "PYTHONNOUSERSITE": "1",
    "PYTHONIOENCODING": "ascii",
    "PYTHONUTF8": "0",
    "LC_ALL": "C",
    "JUPYTER_PREFER_ENV_PATH": "0",
}


def test_packages_that_were_made_for_another_python_are_named_as_such(clone):
    (clone.root / "wheels").mkdir()
    (clone.root / "wheels" / "made-for.txt").write_text("Python 3.99 on Plan9 pdp11\n")
    clone.pin("3.0")
    said = one_sentence(clone.run("test"))
    assert "were made for Python 3.99 on Plan9 pdp11, and this is Python 3." in said
    assert "delete that folder and run the same command again with a network" in said


@pytest.mark.parametrize("uv", [True, False], ids=["uv", "pip"])
def test_the_users_settings_for_other_work_do_not_reach_the_installers(clone, tmp_path, uv):
    """All of them at once; the first Python, `run.py`'s own, must bear them, too."""
    clone.ensurepip.unlink()
    hostile = {"uv.toml": 'exclude-newer = "2001-01-01"\nrequire-hashes = true\n'}
    hostile |= {".config/uv/uv.toml": hostile["uv.toml"], ".config/pip/pip.conf": "[install]\nuser = true\n"}
    for name, text in hostile.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    clone.stub_uv("import sys; sys.exit('no wheels for this machine')")
    clone.package("1.0", "import os, pytest; print(pytest.__file__, '|', *os.environ)")
    foreign = {name: value.format(folder=tmp_path) for name, value in FOREIGN.items()}
    done = clone.run("test", uv=uv, **foreign, UV_NO_CONFIG="0")
    assert done.returncode == 0, done.stdout + done.stderr
    assert ("uv could not" in done.stdout) != uv
    where, _, left = done.stdout.splitlines()[-1].partition(" | ")
    assert Path(where).parent.parent == clone.site_packages()
    harmless = {"VIRTUAL_ENV", "CONDA_PREFIX", "PYTHONNOUSERSITE", "PYTHONIOENCODING", "PYTHONUTF8", "LC_ALL"}
    assert set(left.split()) & set(foreign) <= harmless
    assert not (tmp_path / "elsewhere").exists()


def test_the_users_index_proxy_and_certificate_hold(tmp_path):
    uv = tmp_path / "uv" / "uv.toml"
    uv.parent.mkdir()
    uv.write_text(
        'exclude-newer = "2001-01-01"\nnative-tls = true\nallow-insecure-host = ["a", "b"]\n'
        '[pip]\nextra-index-url = ["e"]\n'
        '[[index]]\nname = "work"\nurl = "w"\n[[index]]\nurl = "d"\ndefault = true\n'
    )
    expected = {"UV_NO_CONFIG": "1", "UV_NATIVE_TLS": "1", "UV_INSECURE_HOST": "a b", "UV_EXTRA_INDEX_URL": "e"}
    expected |= {"UV_INDEX": "work=w", "UV_DEFAULT_INDEX": "d"}
    assert settings.for_uv({"XDG_CONFIG_HOME": str(tmp_path)}) == expected
    del expected["UV_INDEX"]
    assert settings.for_uv({"XDG_CONFIG_HOME": str(tmp_path), "UV_INDEX": "mine"}) == expected, "a variable is stronger"
    listed = "global.cert='c'\nglobal.timeout='9'\ninstall.user='true'\n:env:.target='t'\n"
    listed += "install.extra-index-url='\\na\\nb'\n"
    expected = {
        "PIP_CONFIG_FILE": os.devnull,
        "PIP_CERT": "c",
        "PIP_DEFAULT_TIMEOUT": "9",
        "PIP_EXTRA_INDEX_URL": "a b",
    }
    assert settings.for_pip(listed, {}) == expected
    kept = ("PIP_INDEX_URL", "PIP_CERT", "PIP_PROXY", "UV_DEFAULT_INDEX", "UV_INDEX_WORK_PASSWORD", "HTTPS_PROXY")
    assert not any(settings.is_foreign(name) for name in kept)


@pytest.mark.parametrize(
    "name", ["a  b", "it's", 'say "hi"', "#1 100% $HOME", "Übung 手本", r"back\slash", "-x", "n" * 200]
)
def test_the_folder_may_have_any_name(clone, tmp_path, name):
    if paths.WINDOWS and set(name) & set('"\\'):
        pytest.skip("no name on Windows")
    clone.root = clone.root.rename(tmp_path / name)
    first, second = clone.run("test"), clone.run("test")
    assert first.returncode == 0, first.stdout + first.stderr
    assert second.stdout == "tiny pytest -n 2\n"
    ask = [clone.python, "-c", "import omx; print(ascii(omx.WHERE))"]
    done = subprocess.run(ask, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert Path(ast.literal_eval(done.stdout)).samefile(clone.root / "omx" / "__init__.py")


@pytest.mark.skipif(paths.WINDOWS, reason="names that Windows does not have")
@pytest.mark.parametrize(
    ("name", "told"),
    [("9:12", "divides the entries of PATH"), (os.fsdecode(b"caf\xe9"), "no UTF-8"), ("two\nlines", "two lines")],
)
def test_a_folder_in_which_no_environment_can_be_is_told(clone, tmp_path, name, told):
    clone.root = clone.root.rename(tmp_path / name)
    sentence = one_sentence(clone.run("test"))
    assert told in sentence
    assert "give the folder another name or place" in sentence


@pytest.mark.parametrize("flags", ["-P", "-I", "-OO", "-B", "-X utf8=0"])
def test_pythons_own_options_do_not_matter(clone, flags):
    command = [base_python(), *flags.split(), str(clone.root / "run.py"), "test"]
    done = subprocess.run(command, env=clone.environment(), capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1] == "tiny pytest -n 2", done.stderr


@pytest.mark.skipif(paths.WINDOWS, reason="closed by a POSIX shell")
@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams_do_not_matter(clone, closed):
    clone.package("1.0", "import pathlib; pathlib.Path('ran').touch()")
    words = ["sh", "-c", f'exec "$0" "$1" test {closed}', base_python(), str(clone.root / "run.py")]
    assert subprocess.run(words, env=clone.environment(), check=False, capture_output=True).returncode == 0
    assert (clone.root / "ran").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="Linux has this device")
@pytest.mark.parametrize(("where", "said"), [("| true", ""), ("> /dev/full", "It stops here ([Errno 28] No space")])
def test_a_list_that_nobody_reads_ends_without_a_traceback(clone, where, said):
    words = ["sh", "-c", f'"$0" "$1" {where}', base_python(), str(clone.root / "run.py")]
    error = subprocess.run(words, env=clone.environment(), check=False, capture_output=True, text=True).stderr
    assert said in error
    assert len(error.splitlines()) <= 1


@pytest.mark.parametrize(("where", "said"), [("| true", ""), ("> /dev/full", "run.py: The disk is full"), (">&-", "")])
def test_what_a_tool_says_to_nobody_ends_without_a_traceback(where, said):
    tool = "from book.reader.solutions import main; import time; time.sleep(0.2); raise SystemExit(main(['3.1']))"
    words = ["sh", "-c", f'"$0" -c "{tool}" {where}', sys.executable]
    error = subprocess.run(words, cwd=ROOT, check=False, capture_output=True, text=True).stderr
    assert said in error
    assert len(error.splitlines()) == bool(said)


@pytest.mark.parametrize(
    ("is_checkout", "said"), [(False, "is no git checkout"), (True, "the folder is somebody else's")]
)
def test_a_checkout_that_git_cannot_read_is_no_copy_without_git(tmp_path, monkeypatch, capsys, is_checkout, said):
    if is_checkout:
        (tmp_path / ".git").mkdir()
    monkeypatch.setattr(update, "ROOT", tmp_path)
    monkeypatch.setenv("PATH", "")
    update.pull()
    assert said in capsys.readouterr().out


@pytest.mark.skipif(paths.WINDOWS, reason="Windows has a profile instead of HOME")
def test_where_nothing_can_be_written_a_folder_is_asked_for(clone):
    assert clone.run("test").returncode == 0
    (clone.root / ".venv" / "home").touch()
    done = clone.run("test", HOME=str(clone.root / "missing"))
    assert "let HOME name a folder that can" in one_sentence(done)


@pytest.mark.skipif(paths.WINDOWS, reason="Windows has a profile instead of HOME")
@pytest.mark.parametrize("home", ["missing", "a file"])
def test_without_a_home_folder_there_is_one_in_the_environment(clone, tmp_path, home):
    (tmp_path / "a file").touch()
    clone.package("1.0", "import os, pathlib; print(os.environ['HOME'], os.access(pathlib.Path.home(), os.W_OK))")
    done = clone.run("test", HOME=str(tmp_path / home))
    assert done.stdout.splitlines()[-1] == f"{clone.root / '.venv' / 'home'} True", done.stderr


def test_what_went_missing_or_was_replaced_is_noticed_and_named(clone):
    wheel(clone.wheels, "helper", "1.0", {"helper.py": ""})
    clone.pin(None, "pytest==1.0", "helper==1.0", "uv==0.0.1", "# ---- below")
    assert clone.run("test").returncode == 0
    assert clone.run("test").stdout == "tiny pytest -n 2\n"
    for name in ("helper.py", "helper-1.0.dist-info"):
        path = clone.site_packages() / name
        path.unlink() if path.is_file() else shutil.rmtree(path)
    done = clone.run("test")
    assert "Completing .venv: helper 1.0 is missing, or was replaced by another version." in done.stdout
    assert (clone.site_packages() / "helper.py").exists()
    wheel(clone.wheels, "mine", "1.0", {"mine.py": ""})
    shutil.copytree(clone.site_packages() / "helper-1.0.dist-info", clone.site_packages() / "mine-1.0.dist-info")
    assert clone.run("test").stdout == "tiny pytest -n 2\n", "a package of the reader's own is left alone"


def test_repair_looks_at_an_environment_that_is_called_complete(clone):
    assert clone.run("test").returncode == 0
    (clone.site_packages() / "pytest" / "__main__.py").write_text("half")
    assert clone.run("test").returncode != 0
    assert "Some of its packages are not whole: pytest" in clone.run("repair").stdout
    assert clone.run("test").stdout == "tiny pytest -n 2\n"


def test_a_socket_in_a_long_home_is_counted_in_bytes(monkeypatch):
    monkeypatch.setattr(lab.sys, "platform", "linux")
    for folder, is_short in (("/tmp/" + "a" * 45, True), ("/tmp/" + "a" * 46, False), ("/tmp/" + "手" * 16, False)):
        monkeypatch.setenv("JUPYTER_RUNTIME_DIR", folder)
        assert ("--KernelManager.transport=ipc" in lab.options([])) == is_short, folder


# ---- one clear sentence --------------------------------------------------------------------------------


def test_no_network(clone):
    """The index is a port of this machine on which nobody listens."""
    nobody = "http://127.0.0.1:9/simple"
    offline = {"PIP_INDEX_URL": nobody, "UV_INDEX_URL": nobody, "PIP_FIND_LINKS": "", "UV_FIND_LINKS": ""}
    online = {"PIP_NO_INDEX": "0", "UV_NO_INDEX": "0", "UV_OFFLINE": "0", "UV_HTTP_RETRIES": "0"}
    done = clone.run("test", **offline, **online)
    assert "cannot be reached: check the network connection" in one_sentence(done)
    assert clone.run("test").returncode == 0


def test_full_disk(clone):
    clone.stub_uv("import sys; sys.exit('error: No space left on device (os error 28)')")
    assert "The disk is full" in one_sentence(clone.run("test", uv=False))
    assert clone.run("test").returncode == 0


def test_full_disk_while_the_environment_is_made(clone):
    full = "import errno, venv\ndef full(*_): raise OSError(errno.ENOSPC, 'No space left on device')\n"
    done = clone.run("test", before=full + "venv.EnvBuilder.create = full")
    assert "The disk is full" in one_sentence(done)


def test_a_file_for_which_there_is_no_room_stays_as_it_was(tmp_path, capsys):
    target = tmp_path / "mine.txt"
    target.write_text("mine")

    @paths.in_a_sentence
    def tool():
        with paths.whole(target) as partial:
            partial.write_text("half of the n")
            raise OSError(errno.ENOSPC, "No space left on device")

    assert tool() == 1
    assert capsys.readouterr().err == "run.py: The disk is full; make room and type the same again.\n"
    assert [path.read_text() for path in tmp_path.iterdir()] == ["mine"]


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (PermissionError(errno.EACCES, "Permission denied", "work"), "type this as its owner, or in a copy of your"),
        (OSError(errno.EROFS, "Read-only file system", "work"), "type this as its owner, or in a copy of your own"),
        (NotADirectoryError(errno.ENOTDIR, "Not a directory", "work"), "work is in the way"),
        (OSError(errno.ENOSPC, "No space left on device", "work"), "The disk is full"),
        (OSError(errno.EADDRINUSE, "Address already in use"), "Address already in use"),
        (KeyboardInterrupt(), "run.py: Interrupted."),
    ],
)
def test_what_the_system_refuses_is_told_with_the_way_out(error, said, capsys):
    @paths.in_a_sentence
    def tool():
        raise error

    assert tool() == (130 if isinstance(error, KeyboardInterrupt) else 1)
    assert said in capsys.readouterr().err


def test_read_only_folder(clone):
    full = "import errno, venv\ndef closed(*_): raise PermissionError(errno.EACCES, 'Permission denied', '.venv')\n"
    done = clone.run("test", before=full + "venv.EnvBuilder.create = closed")
    assert ".venv cannot be written (Permission denied)" in one_sentence(done)


def test_no_ensurepip(clone):
    without = "import sys; sys.modules['ensurepip'] = None"
    assert "apt install python3-venv" in one_sentence(clone.run("test", before=without, uv=False))
    assert clone.run("test", before=without).returncode == 0, "uv needs no ensurepip"


@pytest.mark.parametrize("version", [(2, 7, 18), (3, 9, 6), (3, 10, 14)])
def test_python_too_old(clone, version):
    older = f"import sys; sys.version_info = {version}"
    sentence = one_sentence(clone.run("lab", before=older))
    assert f"This is Python {version[0]}.{version[1]}" in sentence
    assert "needs 3.11 or newer" in sentence
    assert not (clone.root / ".venv").exists()


def test_run_py_parses_on_old_pythons():
    ast.parse((ROOT / "run.py").read_text(), feature_version=(3, 4))


def test_a_package_that_does_not_exist(clone):
    clone.pin("9.9")
    sentence = one_sentence(clone.run("test", uv=True))
    assert "Installing the packages failed" in sentence or "uv" in sentence
    clone.pin("1.0")
    assert clone.run("test").returncode == 0


@pytest.mark.parametrize("content", [None, b"", bytes(range(256)), "pytest==1.0\n".encode("utf-16")])
def test_environment_missing_or_no_text(clone, content):
    (clone.root / "environment.txt").unlink()
    if content is not None:
        (clone.root / "environment.txt").write_bytes(content)
    assert "environment.txt is missing beside run.py, or is no text" in one_sentence(clone.run("test"))


def test_hashes_that_cannot_be_read_are_left_aside(clone):
    (clone.root / "book" / "setup" / "hashes.txt").write_bytes(bytes(range(256)))
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest -n 2"


@pytest.mark.skipif(paths.WINDOWS, reason="permissions are POSIX")
def test_a_python_that_does_not_start_is_made_anew(clone):
    assert clone.run("test").returncode == 0
    clone.python.unlink()
    clone.python.mkdir()
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest -n 2"
    clone.python.unlink()
    clone.python.write_text("no program")
    clone.python.chmod(0o755)
    assert "does not start (Exec format error); `python run.py repair` mends it" in one_sentence(clone.run("test"))
    assert clone.run("repair").returncode == 0
    assert clone.run("test").stdout == "tiny pytest -n 2\n"


def test_unknown_command(clone):
    assert "There is no command 'tset'; did you mean 'test'? `python run.py` lists" in one_sentence(clone.run("tset"))
    assert "There is no command 'wxyz'. `python run.py` lists" in one_sentence(clone.run("wxyz"))


def test_every_command_says_how_it_is_used(clone):
    for command in launch.COMMANDS:
        if command.name not in launch.USAGE:  # its tool has a parser, and calls itself as readers do
            path = importlib.util.find_spec(command.calls[-1].split()[1]).origin.replace("__init__", "__main__")
            assert f'"python run.py {command.name}"' in Path(path).read_text(encoding="utf-8"), command.name
    for name in ("test", "repair", "lock"):
        for question in ("-h", "--help"):
            asked = clone.run(name, "more", question)
            assert asked.stdout.startswith(f"usage: python run.py {name}"), asked
            assert not asked.stderr
    assert not (clone.root / ".venv").exists(), "a question sets nothing up"


# ---- launching -----------------------------------------------------------------------------------------


def test_only_commands_whose_tool_exists_are_offered(clone):
    offered = {line.split()[0] for line in clone.run().stdout.splitlines()[2:]}
    assert offered == {command.name for command in launch.COMMANDS if (clone.root / command.needs).exists()}
    assert {"test", "lock"} <= offered
    assert "lab" not in offered, "there are no notebooks in this copy"


def test_every_command_runs_a_module_that_is_there():
    for command in launch.COMMANDS:
        assert (ROOT / command.needs).exists(), command
        for call in command.calls:
            assert importlib.util.find_spec(call.split()[1]), call


def test_the_tool_starts_clean(clone):
    clone.package("1.0", "import os; print({n: n in os.environ for n in ('PYTHONPATH', 'PYTHONDONTWRITEBYTECODE')})")
    done = clone.run("test", PYTHONDONTWRITEBYTECODE="1", PYTHONPATH="/elsewhere")
    assert done.stdout.splitlines()[-1] == "{'PYTHONPATH': False, 'PYTHONDONTWRITEBYTECODE': False}"


def test_the_tools_status_is_ours(clone):
    clone.package("1.0", "raise SystemExit(5)")
    assert clone.run("test").returncode == 5


def test_starting_loads_the_standard_library_only():
    code = "import sys; before = set(sys.modules); import book.setup.launch, book.setup.set_up, book.setup.lock; "
    code += "loaded = [n for n in set(sys.modules) - before if sys.modules[n]]; "
    code += "print(*(n for n in loaded if n.split('.')[0] not in sys.stdlib_module_names))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert {name.split(".")[0] for name in done.stdout.split()} == {"book"}


def test_lab_listens_on_loopback_and_opens_the_first_chapter_of_the_reader():
    notebook, options = lab.command_line(["--no-browser"])
    assert "--ServerApp.ip=127.0.0.1" in options
    assert "--no-browser" in options
    first = min(paths.NOTEBOOKS.glob("*.ipynb")).name
    assert notebook == paths.WORK / first
    assert options[-1] == f"--LabApp.default_url=/lab/tree/work/{first}"
    assert lab.command_line(["--author"])[0] == paths.NOTEBOOKS / first


@pytest.mark.parametrize(
    ("given", "ours"),
    [
        ("--ServerApp.root_dir=elsewhere", "root_dir"),
        ("--notebook-dir=elsewhere", "root_dir"),
        ("--ServerApp.notebook_dir=elsewhere", "root_dir"),
        ("--ip=127.0.0.2", "ServerApp.ip"),
        ("--debug", "log_level"),
    ],
)
def test_an_option_of_the_reader_replaces_ours_in_any_spelling(given, ours):
    said = [option for option in lab.options([given]) if ours in option]
    assert len(said) == 1, "JupyterLab takes each option once"
    assert said[0].split("=")[1] == given.partition("=")[2] or given == "--debug"


def test_a_number_that_is_no_port_is_told():
    lab.must_be_a_port(8888)
    with pytest.raises(paths.Stop, match="80000 is no port"):
        lab.must_be_a_port(80000)


def test_a_folder_in_which_jupyter_can_keep_nothing_is_named(tmp_path):
    lab.can_keep_files(tmp_path / "new")
    (tmp_path / "file").touch()
    with pytest.raises(paths.Stop, match=r"file/x \(Not a directory\): let JUPYTER_RUNTIME_DIR name a folder of yours"):
        lab.can_keep_files(tmp_path / "file" / "x")


def test_a_notebook_outside_is_named_with_the_way_to_open_it(tmp_path):
    notebook = tmp_path / "mine.ipynb"
    notebook.write_text("{}")
    with pytest.raises(paths.Stop, match=f"not below .* or add --notebook-dir={tmp_path}"):
        lab.command_line([str(notebook)])
    opened, options = lab.command_line([str(notebook), f"--notebook-dir={tmp_path}"])
    assert opened == notebook
    assert options[-1] == "--LabApp.default_url=/lab/tree/mine.ipynb"


@pytest.mark.parametrize(
    ("name", "chapter"),
    [
        *(("1", "01"), ("3", "03"), ("03", "03"), ("10", "10"), ("forward", "03"), ("03-forward-kinematics", "03")),
        *(("Forward Kinematics", "03"), ("03-forward-kinematics.ipynb", "03"), ("0", "00")),
    ],
)
def test_one_rule_names_a_chapter(name, chapter):
    assert names.chapter(name).name.startswith(f"{chapter}-")
    assert names.chapter(name, paths.WORK).parent == paths.WORK


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("lab", "fits more than one chapter: 10-lab-fk, 11-lab-ik"),
        ("77", "There is no chapter '77'; the chapters are 00-"),
        ("build/student/01", "There is no file 'build/student/01'"),
        ("../01-planar-arms.ipynb", "There is no file"),
    ],
)
def test_what_names_no_chapter_is_told(name, told, monkeypatch):
    monkeypatch.chdir(ROOT / "tests")
    with pytest.raises(paths.Stop, match=re.escape(told)):
        names.chapter(name)


@pytest.mark.parametrize(
    ("module", "arguments", "told"),
    [
        ("publish.slides", ["nothing"], "There is no chapter 'nothing'"),
        ("chapters.edition", ["nothing"], "There is no chapter 'nothing'"),
        ("chapters.edition", ["--edition", "FOLDER"], "cannot be written: name a file"),
        ("chapters.edition", ["--edition", "FOLDER/none/x.zip"], "cannot be written: name a file"),
        ("reader.handin", ["99"], "There is no chapter '99'"),
        ("reader.solutions", ["x"], "'x' is no exercise"),
        ("chapters.new", ["../x"], "must be words in small letters"),
    ],
)
def test_a_tool_says_in_a_sentence_what_it_cannot_take(module, arguments, told, tmp_path, capsys):
    said = ""
    try:
        importlib.import_module(f"book.{module}").main([word.replace("FOLDER", str(tmp_path)) for word in arguments])
    except (SystemExit, paths.Stop) as stop:
        said = str(stop)
    assert told in said + capsys.readouterr().err
    assert not list(tmp_path.iterdir()), "no half of a file stays"


def test_a_path_opens_that_file_and_a_labs_duplicate_is_no_chapter(tmp_path, monkeypatch):
    (tmp_path / "03-forward-kinematics.ipynb").touch()
    (tmp_path / "03-forward-kinematics-Copy1.ipynb").touch()
    monkeypatch.setattr(names, "NOTEBOOKS", tmp_path)
    assert names.chapter(str(tmp_path / "03-forward-kinematics-Copy1.ipynb")).name.endswith("Copy1.ipynb")
    assert names.chapter("3", tmp_path) == names.chapter(str(tmp_path / "03-forward-kinematics.ipynb"))
    assert [path.name for path in names.chapters()] == ["03-forward-kinematics.ipynb"]


# ---- the lock ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("newest", [False, True])
def test_lock_rewrites_the_lower_part(clone, newest):
    for version in ("1.0", "1.1"):
        wheel(clone.wheels, "helper", version, {"helper.py": ""})
    clone.package("1.5")
    above = ["# by hand", "pytest==1.0  # a reason", "helper==1.0 ; sys_platform != 'nowhere'", "# ---- below"]
    clone.pin(None, *above, "stale==9.9")
    done = clone.run("lock", *["--newest"][: int(newest)])
    assert done.returncode == 0, done.stderr
    lines = (clone.root / "environment.txt").read_text().splitlines()
    if newest:
        above = [line.replace("pytest==1.0", "pytest==1.5").replace("helper==1.0", "helper==1.1") for line in above]
    assert lines == above
    assert "2 packages by hand, 0 that they need" in done.stdout


def test_locked_files_are_installed_by_their_hashes_and_no_others(clone):
    assert clone.run("lock").returncode == 0
    assert "--hash=sha256:" in (clone.root / "book" / "setup" / "hashes.txt").read_text()
    assert clone.run("test").returncode == 0
    shutil.rmtree(clone.root / ".venv")
    clone.package("1.0", "print('another pytest 1.0')")
    assert "Installing the packages failed" in one_sentence(clone.run("test"))
    assert "hash" in (clone.root / ".venv" / "set-up.log").read_text().lower()
    assert not clone.stamp.exists()


def test_the_hashes_are_those_of_todays_pins():
    assert paths.requirements() == paths.HASHES, "python run.py lock"
    text = paths.HASHES.read_text()
    assert text.count("--hash=sha256:") > text.count("==")


def test_lock_leaves_the_file_when_nothing_fits(clone):
    clone.pin("7.7")
    before = (clone.root / "environment.txt").read_text()
    assert "cannot be resolved" in clone.run("lock").stderr
    assert (clone.root / "environment.txt").read_text() == before


def test_package_names_are_compared_normalised():
    assert lock.package_of("Jupyter_Client==1") == lock.package_of("jupyter.client") == "jupyter-client"
    assert lock.package_of("# numpy==1") == lock.package_of("") == ""


@pytest.mark.parametrize(
    "said",
    ["  cause: error sending request for url\n  cause: invalid peer certificate: UnknownIssuer",
     "SSLCertVerificationError(1, '[SSL: CERTIFICATE_VERIFY_FAILED] certificate verify failed: self-signed"],
    ids=["uv", "pip"],
)  # fmt: skip
def test_a_certificate_that_is_not_trusted_is_no_matter_of_the_cable(said):
    failed = installers.Failed(said.splitlines())
    assert "let SSL_CERT_FILE and PIP_CERT name the file" in str(failed)
    assert failed.unreachable, "nothing is built anew for it"


def test_sentences_for_the_disk_name_what_is_free():
    assert "MB are free" in installers.disk_full()
