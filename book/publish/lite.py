"""Build JupyterLite: the book in the browser alone, Python included. `python run.py lite` writes build/lite.

    python -m book.publish.lite                     # Pyodide's core from npm: pure Python only, so SymPy but no NumPy
    python -m book.publish.lite --pyodide FOLDER    # with a full Pyodide distribution, unpacked: every chapter below

Chapters that need a bus, and so a serial port or threads, are left out. `omx` and what it needs go into Pyodide's
own list of packages, so that `import omx` loads them; nothing is asked of any server but the one with these files.
"""

import argparse
import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

from book.chapters import runs
from book.chapters.normalise import read, write
from book.chapters.student import Refused, student_copy
from book.publish import notices, npm
from book.setup import extra_envs
from book.setup.paths import ROOT, Stop, child_environment

BUILD = ROOT / "build"
SOURCE, LITE, WHEELS = BUILD / "lite-source", BUILD / "lite", BUILD / "lite-wheels"
NEEDS_A_BUS = ("06", "07", "08", "09")
#: What the kernel itself needs, and what the chapters import: of these, and of all they depend on, wheels are laid out.
WANTED = ("micropip", "ipython", "sympy", "numpy", "matplotlib", "packaging", "traitlets", "typing-extensions")
#: Packages that Pyodide's list lacks, and what they depend on; pure Python, pinned in environment.txt.
EXTRA = {
    "omx": ("numpy", "u-msgpack-python", "anywidget", "meshcat"),
    "u-msgpack-python": (),
    "meshcat": (),
    "anywidget": ("ipywidgets", "psygnal", "typing-extensions"),
    "ipywidgets": ("ipython", "traitlets", "jupyterlab-widgets"),
    "jupyterlab-widgets": (),
    "psygnal": (),
    "comm": ("traitlets",),  # this and the next two: the kernel's own
    "jedi": ("parso",),
    "parso": (),
}
#: The kernel asks no package index; what is not among these files is missing.
SETTINGS = {"@jupyterlite/pyodide-kernel-extension:kernel": {"disablePyPIFallback": True}}
IMPORTS = {"u-msgpack-python": "umsgpack", "jupyterlab-widgets": "jupyterlab_widgets"}


def build(pyodide=None):
    """Write build/lite; the names of the packages that the browser's Python will lack."""
    python = extra_envs.python("lite")
    for folder in (SOURCE, LITE):
        shutil.rmtree(folder, ignore_errors=True)
    static = SOURCE / "static" / "pyodide"
    core = pyodide or npm.modules(ROOT / "book" / "lite", BUILD / "npm-lite") / "pyodide"
    shutil.copytree(core, static, ignore=shutil.ignore_patterns("*.map", "*.d.ts", "*.html", "node_modules"))
    missing = lay_out_packages(static, python, complete=pyodide is not None)
    lay_out_chapters(SOURCE / "files")
    config = {"jupyter-lite-schema-version": 0, "jupyter-config-data": {"litePluginSettings": SETTINGS}}
    (SOURCE / "jupyter-lite.json").write_text(json.dumps(config), encoding="utf-8")
    command = [python, "-m", "jupyterlite_core", "build", "--lite-dir", SOURCE, "--contents", SOURCE / "files"]
    run([*command, "--output-dir", LITE, "--no-sourcemaps", "--apps", "lab", "--apps", "repl"], "JupyterLite", SOURCE)
    notices.write(LITE, notices.LITE, [core] if (core / "LICENSE").exists() else [], packages_of(python))
    return missing


def packages_of(python):
    """The places where the packages of an environment lie: its own and the book's."""
    asked = subprocess.run([python, "-c", "import sys; print(*sys.path, sep='\\n')"], capture_output=True, text=True,
                           env=child_environment(), check=True)  # fmt: skip
    return [place for place in asked.stdout.splitlines() if "site-packages" in place]


def lay_out_chapters(folder):
    """Student copies of the chapters that need no bus."""
    folder.mkdir(parents=True)
    for path in runs.chapters():
        if not path.name.startswith(NEEDS_A_BUS):
            write(folder / path.name, student_copy(read(path)))


def lay_out_packages(static, python, complete):
    """Put wheels beside Pyodide and rewrite its list of packages; the wanted ones that cannot be had here."""
    lock = json.loads((static / "pyodide-lock.json").read_text(encoding="utf-8"))
    known, missing = lock["packages"], []
    wanted = closure(WANTED, known)
    lock["packages"] = known if complete else {}
    for name in [] if complete else wanted:
        if wheel := pure_wheel(python, name, known[name]["version"], known[name]["file_name"]):
            lock["packages"][name] = {**known[name], **laid_out(wheel, static)}
        elif known[name]["package_type"] == "package":
            missing.append(name)
    for name, needs in EXTRA.items():
        wheel = own_wheel() if name == "omx" else pure_wheel(python, name, pinned(name))
        if wheel is None:
            missing.append(name)
            continue
        lock["packages"][name] = entry(name, wheel, needs) | laid_out(wheel, static)
    for about in lock["packages"].values():
        about["depends"] = [plain(need) for need in about["depends"] if plain(need) in lock["packages"]]
    (static / "pyodide-lock.json").write_text(json.dumps(lock), encoding="utf-8")
    return missing


def closure(names, known):
    """The packages with all that they depend on."""
    found, waiting = [], list(names)
    while waiting:
        name = plain(waiting.pop(0))
        if name in known and name not in found:
            found.append(name)
            waiting += known[name]["depends"]
    return found


def plain(name):
    """A package's name as an index writes it."""
    return name.lower().replace("_", "-").replace(".", "-")


def pure_wheel(python, name, version, file_name="py3-none-any.whl"):
    """The wheel of a pure Python package from the package index, kept in build/lite-wheels; None if there is none."""
    if not file_name.endswith("none-any.whl"):
        return None
    pattern = f"{name.replace('-', '_')}-{version}-*none-any.whl"
    if not list(WHEELS.glob(pattern)):
        command = [python, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:", "--platform=any"]
        command += ["--python-version=3.14", "--dest", WHEELS, f"{name}=={version}"]
        subprocess.run(command, env=child_environment(), capture_output=True, check=False)
    return next(iter(WHEELS.glob(pattern)), None)


def own_wheel():
    """A wheel of `omx` as it is now."""
    for old in WHEELS.glob("omx-*.whl"):
        old.unlink()
    command = [sys.executable, "-m", "uv", "build", "--quiet", "--wheel", "--no-build-isolation", "--out-dir", WHEELS]
    run([*command, ROOT], "building omx", ROOT)
    return next(WHEELS.glob("omx-*.whl"))


def laid_out(wheel, static):
    """Copy a wheel beside Pyodide; its entries in the list."""
    shutil.copyfile(wheel, static / wheel.name)
    return {"file_name": wheel.name, "sha256": hashlib.sha256(wheel.read_bytes()).hexdigest()}


def entry(name, wheel, needs):
    """A package for Pyodide's list."""
    about = {"name": name, "version": wheel.name.split("-")[1], "install_dir": "site", "package_type": "package"}
    return {**about, "imports": [IMPORTS.get(name, name)], "depends": list(needs), "unvendored_tests": False}


def pinned(name):
    """A package's version in environment.txt."""
    for line in (ROOT / "environment.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith(name + "=="):
            return line.split("==")[1].split()[0]
    raise Stop(f"environment.txt does not pin {name}, which the browser's Python needs.")


def run(command, what, folder):
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=folder, env=child_environment(), capture_output=True, text=True, check=False)
    if done.returncode:
        said = [line for line in (done.stderr + done.stdout).splitlines() if line.strip()] or ["it said nothing"]
        raise Stop(f"{what} failed: {said[-1][:300]}")


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--pyodide", type=Path, metavar="FOLDER", help="a full Pyodide distribution, unpacked")
    options = parser.parse_args(argv)
    try:
        missing = build(options.pyodide and options.pyodide.resolve())
    except (Stop, Refused, OSError) as error:
        print(f"lite: {error}", file=sys.stderr)
        return 1
    print(f"JupyterLite is in {LITE.relative_to(ROOT)}; any static web server can serve it.")
    if missing:
        print(
            f"Its Python lacks {', '.join(missing)}: their builds for the browser are not on the package index. "
            "Without NumPy only SymPy runs; `--pyodide FOLDER` takes a full Pyodide distribution, which has them."
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
