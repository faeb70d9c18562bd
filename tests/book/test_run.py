"""The launcher, tried on copies of itself with an environment of one tiny package, without any network."""

import ast
import hashlib
import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

from book.setup import installers, launch, lock, paths
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
    def python(self):
        return self.root / paths.PYTHON.relative_to(paths.ROOT)

    @property
    def stamp(self):
        return self.root / ".venv" / paths.STAMP.name

    def site_packages(self):
        return next(self.root.glob(".venv/[Ll]ib/**/site-packages"))


def base_python():
    return getattr(sys, "_base_executable", sys.executable)


@pytest.fixture
def clone(tmp_path):
    if UV is None:
        pytest.skip("uv is not installed")
    return Clone(tmp_path)


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
    assert first.stdout.splitlines()[-2:] == ["Set-up complete.", "tiny pytest -x"]
    assert len(first.stdout.splitlines()) <= 6
    second = clone.run("test")
    assert second.stdout == "tiny pytest\n"


def test_omx_is_imported_from_any_folder_even_after_moving(clone, tmp_path):
    assert clone.run("test").returncode == 0
    clone.root = clone.root.rename(tmp_path / "moved")
    where = subprocess.run(
        [clone.python, "-c", "import omx; print(omx.WHERE)"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert Path(where.stdout.strip()).samefile(clone.root / "omx" / "__init__.py")
    assert clone.run("test").stdout == "tiny pytest\n"


def test_a_changed_environment_is_installed(clone):
    assert clone.run("test").returncode == 0
    clone.package("2.0", "print('newer')")
    clone.pin("2.0")
    done = clone.run("test")
    assert done.stdout.splitlines()[-1] == "newer"
    assert "environment.txt has changed" in done.stdout


def test_without_uv_on_the_path_the_pinned_one_is_used(clone):
    done = clone.run("test", uv=False)
    assert done.stdout.splitlines()[-1] == "tiny pytest", done.stdout + done.stderr
    assert "stub" in (clone.root / ".venv" / "set-up.log").read_text()


def test_without_any_working_uv_pip_does_it(clone):
    clone.stub_uv("import sys; sys.exit('no wheels for this machine')")
    done = clone.run("test", uv=False)
    assert done.stdout.splitlines()[-1] == "tiny pytest", done.stdout + done.stderr
    assert "uv could not: no wheels for this machine" in done.stdout


def test_a_venv_without_stamp_is_completed_not_rebuilt(clone):
    assert clone.run("test").returncode == 0
    clone.stamp.unlink()
    (clone.root / ".venv" / "mine").touch()
    shutil.rmtree(clone.site_packages() / "pytest")
    shutil.rmtree(next(clone.site_packages().glob("pytest-*")))
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest"
    assert (clone.root / ".venv" / "mine").exists()


def test_a_package_that_lost_files_is_noticed_and_all_is_built_anew(clone):
    assert clone.run("test").returncode == 0
    clone.stamp.unlink()
    (clone.root / ".venv" / "mine").touch()
    (clone.site_packages() / "pytest" / "__main__.py").write_text("half")
    done = clone.run("test")
    assert "Some of its packages are not whole: pytest" in done.stdout
    assert done.stdout.splitlines()[-1] == "tiny pytest"
    assert not (clone.root / ".venv" / "mine").exists()


@pytest.mark.parametrize("debris", ["file", "broken link", "empty folder", "no interpreter"])
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
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest"


def test_a_link_to_another_disk_stays(clone, tmp_path):
    venv = clone.root / ".venv"
    (tmp_path / "big disk" / "old").mkdir(parents=True)
    venv.symlink_to(tmp_path / "big disk", target_is_directory=True)
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest"
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
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest"


@pytest.mark.skipif(paths.WINDOWS, reason="signals to process groups are POSIX")
def test_ctrl_c_says_how_to_go_on(clone):
    status, said = stopped_by(clone, signal.SIGINT)
    assert status == 130
    assert said.strip() == "run.py: Interrupted; the same command takes it up again."
    assert clone.run("test").stdout.splitlines()[-1] == "tiny pytest"


def test_two_first_runs_wait_for_each_other(clone):
    commands = [[base_python(), str(clone.root / "run.py"), "test"] for _ in range(2)]
    pair = [
        subprocess.Popen(command, env=clone.environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for command in commands
    ]
    said = [process.communicate(timeout=120) for process in pair]
    assert [process.returncode for process in pair] == [0, 0], said
    assert sorted("Set-up complete." in out for out, _ in said) == [False, True]
    assert all(out.splitlines()[-1] == "tiny pytest" for out, _ in said)


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


def test_environment_missing(clone):
    (clone.root / "environment.txt").unlink()
    assert "environment.txt is missing" in one_sentence(clone.run("test"))


def test_unknown_command_and_chapter(clone):
    assert "There is no command 'tset'; the commands are test" in one_sentence(clone.run("tset"))
    (clone.root / "notebooks").mkdir()
    (clone.root / "notebooks" / "00-start.ipynb").write_text("{}")
    assert clone.run("test").returncode == 0
    assert "There is no chapter '07'; the chapters are 00-start." in one_sentence(clone.run("lab", "07"))


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


def test_lab_listens_on_loopback_and_opens_the_first_chapter():
    arguments = launch.lab_arguments(["--no-browser"])
    assert "--ServerApp.ip=127.0.0.1" in arguments
    assert "--no-browser" in arguments
    assert Path(arguments[-1]) == sorted(paths.NOTEBOOKS.glob("*.ipynb"))[0]


def test_an_option_of_the_reader_replaces_ours():
    arguments = launch.lab_arguments(["--ServerApp.root_dir=elsewhere"])
    assert [a for a in arguments if "root_dir" in a] == ["--ServerApp.root_dir=elsewhere"]


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


def test_lock_leaves_the_file_when_nothing_fits(clone):
    clone.pin("7.7")
    before = (clone.root / "environment.txt").read_text()
    assert "cannot be resolved" in clone.run("lock").stderr
    assert (clone.root / "environment.txt").read_text() == before


def test_package_names_are_compared_normalised():
    assert lock.package_of("Jupyter_Client==1") == lock.package_of("jupyter.client") == "jupyter-client"
    assert lock.package_of("# numpy==1") == lock.package_of("") == ""


def test_sentences_for_the_disk_name_what_is_free():
    assert "MB are free" in installers.disk_full()
