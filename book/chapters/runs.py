"""The chapters with their outputs, run once for the site and the slides together.

A run is kept in build/executed and used again while the chapter's code, `omx` and environment.txt stay as they
are; prose may change freely. Scenes and panels come out as HTML (OMX_VIEW=shared), and what a chapter generates
goes to build/executed, not into `omx`.
"""

import base64
import concurrent.futures
import copy
import hashlib
import io
import json
import os
import shutil
import time
from pathlib import Path

from PIL import Image

from book.chapters import execute, normalise
from book.setup.paths import ENVIRONMENT, NOTEBOOKS, ROOT, Stop

FOLDER = ROOT / "build" / "executed"
AT_ONCE = 2


def chapters():
    """The paths of all chapters, in order."""
    return sorted(NOTEBOOKS.glob("*.ipynb"))


def run_all(paths=None, folder=FOLDER):
    """Run those chapters whose code or `omx` changed; the path of the kept run of each. Raises `execute.Failed`."""
    paths = list(paths or chapters())
    package = fingerprint_of_package()
    stale = [path for path in paths if key_of_run(kept(path, folder)) != key(path, package)]
    with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        for report in pool.map(lambda path: run(path, package, folder), stale):
            print(report, flush=True)
    return {path: kept(path, folder) for path in paths}


def run(path, package, folder):
    """Run one chapter and keep it; a line that says how long it took."""
    start = time.perf_counter()
    keep(path, execute.run(path, env={**os.environ, **variables(path, folder)}), package, folder)
    return f"{path.name} ran in {time.perf_counter() - start:.1f} s"


def variables(path, folder=FOLDER):
    """What a chapter's kernel finds in its environment: scenes as HTML, an empty folder for what it generates."""
    shutil.rmtree(generated(path, folder), ignore_errors=True)
    generated(path, folder).mkdir(parents=True)
    return {"OMX_VIEW": "shared", "OMX_GENERATED": str(generated(path, folder)), "PYTHONHASHSEED": "0"}


def generated(path, folder=FOLDER):
    """Where the kept run of a chapter has written its modules."""
    return folder / "generated" / path.stem


def keep(path, notebook, package=None, folder=FOLDER):
    """Store a run (a NotebookNode with outputs): streams joined, pictures made small."""
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = normalise.join_streams(cell.outputs)
            for output in cell.outputs:
                if "image/png" in output.get("data", {}):
                    output["data"]["image/png"] = slim(output["data"]["image/png"])
    notebook.metadata["omx_key"] = key(path, package or fingerprint_of_package())
    kept(path, folder).write_text(json.dumps(notebook, indent=1), encoding="utf-8")


def slim(png):
    """A picture (base64) in 128 colours: for line drawings the same to the eye, at a third of the bytes."""
    picture = Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB")
    small = io.BytesIO()
    picture.quantize(128, dither=Image.Dither.NONE).save(small, "png", optimize=True)
    return min(png, base64.b64encode(small.getvalue()).decode(), key=len)


def merged(path, folder=FOLDER):
    """The chapter as it is written now (parsed JSON), with the outputs of its kept run. Raises `Stop`."""
    notebook, done = normalise.read(path), normalise.read(kept(path, folder))
    here, there = ([cell for cell in each["cells"] if cell["cell_type"] == "code"] for each in (notebook, done))
    if code(here) != code(there):
        raise Stop(f"{path.name} was changed while the book was built; build it again.")
    for cell, run_before in zip(here, there, strict=True):
        cell["outputs"] = copy.deepcopy(run_before["outputs"])
    return notebook


def kept(path, folder=FOLDER):
    return folder / path.name


def key(path, package):
    """A hash of all that a chapter's outputs depend on: its code, the package, the environment."""
    cells = [cell for cell in normalise.read(path)["cells"] if cell["cell_type"] == "code"]
    return hashlib.sha256((package + json.dumps(code(cells))).encode()).hexdigest()


def code(cells):
    """What of code cells decides on their outputs."""
    return [(normalise.text_of(cell["source"]), cell["metadata"].get("tags")) for cell in cells]


def key_of_run(path):
    try:
        return normalise.read(path)["metadata"].get("omx_key")
    except (OSError, ValueError):
        return None


def fingerprint_of_package():
    """A hash of environment.txt and of every file of `omx`."""
    files = [p for p in sorted((ROOT / "omx").rglob("*")) if p.is_file() and "__pycache__" not in p.parts]
    digest = hashlib.sha256(ENVIRONMENT.read_bytes())
    for path in files:
        digest.update(str(Path(path).relative_to(ROOT)).encode() + path.read_bytes())
    return digest.hexdigest()
