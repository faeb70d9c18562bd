"""What the site, the slides and JupyterLite carry from others, with their licences: one text file beside the pages."""

import json
import zipfile
from importlib.metadata import distributions
from pathlib import Path

NAME = "third-party-notices.txt"
#: Python packages whose scripts, styles or bundles are copied into what is built.
SCENES = ("meshcat",)
SLIDES = (*SCENES, "pygments")
SITE = (*SLIDES, "sphinx", "sphinx-book-theme", "pydata-sphinx-theme", "sphinx-design", "myst-nb")
LITE = (*SCENES, "jupyterlite-core", "jupyterlite-pyodide-kernel")
NPM = ("mathjax", "reveal.js")
HEAD = """This folder carries work of others. The book's own text is CC BY 4.0, its own code BSD 3-Clause. What follows
are the packages of others in here, each with its version, the name of its licence, and the licence itself.
"""


def write(folder, packages, npm_packages=(), where=None):
    """Write the notices of these packages, and of the wheels and bundles found in `folder`; the path.

    `npm_packages` are folders; `where` lists the places of the Python packages, by default this Python's own.
    """
    found = dict(entry for name in packages for entry in of_package(name, where))
    found |= dict(of_npm(path) for path in npm_packages)
    found |= dict(entry for path in sorted(folder.rglob("third-party-licenses.json")) for entry in of_bundle(path))
    found |= dict(of_wheel(path) for path in sorted(folder.rglob("*.whl")))
    line = "\n" + "-" * 100 + "\n"
    text = line.join([HEAD, *(f"{title}\n\n{licence.strip()}\n" for title, licence in sorted(found.items()))])
    path = folder / NAME
    path.write_text(text, encoding="utf-8", newline="\n")
    return path


def of_package(name, where=None):
    """(title, licence) of an installed package, and of what its bundle lists. Raises `LookupError` if it has none."""
    paths = {} if where is None else {"path": [str(path) for path in where]}
    package = next((p for p in distributions(name=name, **paths)), None)
    files = [file for file in (package.files if package else None) or () if is_licence(file)]
    if not files:
        raise LookupError(f"{name} has no licence file")
    about = package.metadata.get("License-Expression") or package.metadata.get("License") or "see below"
    texts = [file.read_text(encoding="utf-8") for file in files]
    yield f"{name} {package.version}: {about.splitlines()[0]}", "\n\n".join(texts)
    for file in package.files:
        if file.name.endswith("THIRD_PARTY_LICENSES.json"):
            yield from of_bundle(Path(package.locate_file(file)))


def is_licence(file):
    """Is this path the licence of a package (and not that of something deep inside it)?"""
    return ".dist-info/" in file.as_posix() and file.name.lower().startswith(("licen", "copying", "notice"))


def of_bundle(path):
    """(title, licence) of each part of a JavaScript bundle, from the list that its maker's build wrote."""
    listed = json.loads(path.read_text(encoding="utf-8"))
    for part in listed["packages"] if isinstance(listed, dict) else listed:
        version = part.get("version") or part.get("versionInfo")
        licence = part.get("licenseText") or part.get("extractedText") or "(its package carries no text of it)"
        yield f"{part['name']} {version}: {part.get('license') or part.get('licenseId')}", licence


def of_npm(path):
    """(title, licence) of an npm package's folder."""
    about = json.loads((path / "package.json").read_text(encoding="utf-8"))
    files = sorted(file for file in path.iterdir() if file.name.lower().startswith(("licen", "copying")))
    if not files:
        raise LookupError(f"{about['name']} has no licence file")
    return f"{about['name']} {about['version']}: {about.get('license')}", files[0].read_text(encoding="utf-8")


def of_wheel(path):
    """(title, licence) of a wheel."""
    with zipfile.ZipFile(path) as wheel:
        names = [name for name in wheel.namelist() if is_licence(Path(name))]
        texts = [wheel.read(name).decode("utf-8", "replace") for name in sorted(names)]
    name, version = path.name.split("-")[:2]
    return f"{name} {version}", "\n\n".join(texts) or "(its package carries no text of it)"
