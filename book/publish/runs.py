"""The chapters with their outputs, run once for the site and the slides together.

A run is kept in build/executed and used again while the chapter's code, `omx` and environment.txt stay as they
are; prose may change freely. Scenes and panels come out as data (OMX_VIEW=data), and what a chapter generates goes
to build/executed, not into `omx`. What several scenes hold (the arm, light, ground) is gathered in one `stock`.
"""

import base64
import concurrent.futures
import hashlib
import io
import json
import os
import shutil
import time
from collections import Counter
from pathlib import Path

from PIL import Image

from book.chapters import execute, normalise
from book.chapters.cells import tags
from book.publish import scenes
from book.publish.still_picture import with_poster
from book.setup.paths import ENVIRONMENT, NOTEBOOKS, ROOT, Stop
from omx.display.viewer.html_export import as_text

FOLDER = ROOT / "build" / "executed"
AT_ONCE = 2
#: The tag of a cell whose text no test compares.
VARIES = "nbval-ignore-output"


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
    gather(folder)
    return {path: kept(path, folder) for path in paths}


def run(path, package, folder):
    """Run one chapter and keep it; a line that says how long it took."""
    start = time.perf_counter()
    keep(path, execute.run(path, env={**os.environ, **variables(path, folder)}), package, folder)
    return f"{path.name} ran in {time.perf_counter() - start:.1f} s"


def variables(path, folder=FOLDER):
    """What a chapter's kernel finds in its environment: scenes as data, an empty folder for what it generates."""
    shutil.rmtree(generated(path, folder), ignore_errors=True)
    generated(path, folder).mkdir(parents=True)
    return {"OMX_VIEW": "data", "OMX_GENERATED": str(generated(path, folder)), "PYTHONHASHSEED": "0"}


def generated(path, folder=FOLDER):
    """Where the kept run of a chapter has written its modules."""
    return folder / "generated" / path.stem


def keep(path, notebook, package=None, folder=FOLDER):
    """Store a run (a NotebookNode with outputs): streams joined, pictures made small, scenes drawn for paper."""
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = normalise.join_streams(cell.outputs)
            for data in (output.get("data", {}) for output in cell.outputs):
                if "image/png" in data:
                    data["image/png"] = slim(data["image/png"])
                if scenes.SCENE in data:
                    data[scenes.SCENE] = with_poster(data[scenes.SCENE])
    notebook.metadata["omx_key"] = key(path, package or fingerprint_of_package())
    kept(path, folder).write_text(json.dumps(notebook), encoding="utf-8")


def slim(png):
    """A picture (base64) in 128 colours: for line drawings the same to the eye, at a third of the bytes."""
    picture = Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB")
    small = io.BytesIO()
    picture.quantize(128, dither=Image.Dither.NONE).save(small, "png", optimize=True)
    return min(png, base64.b64encode(small.getvalue()).decode(), key=len)


def gather(folder=FOLDER):
    """Keep what two scenes or more hold, as one stock."""
    held, users = {}, Counter()
    for path in filter(Path.exists, (kept(path, folder) for path in chapters())):
        for cell in normalise.read(path)["cells"]:
            for output in cell.get("outputs", ()):
                objects = scenes.objects(output.get("data", {}).get(scenes.SCENE, {}))
                held |= objects
                users.update(objects.keys())
    text = as_text({name: held[name] for name in sorted(held) if users[name] > 1})
    if not stock_of(folder).exists() or stock_of(folder).read_text(encoding="ascii") != text:
        stock_of(folder).write_text(text, encoding="ascii")  # all pages are written anew


def stock(folder=FOLDER):
    """The objects that several scenes of the book hold, by their keys; none before a run."""
    path = stock_of(folder)
    return scenes.from_text(path.read_text(encoding="ascii")) if path.exists() else {}


def merged(path, folder=FOLDER):
    """The chapter as it is written now (parsed JSON), with the outputs of its kept run, scenes as HTML. Raises `Stop`.

    They leave out what is in the stock. Text that comes out otherwise in every run (timings, say) is the one that
    is stored in the notebook: the same commit makes the same pages.
    """
    notebook, done = normalise.read(path), normalise.read(kept(path, folder))
    here, there = ([cell for cell in each["cells"] if cell["cell_type"] == "code"] for each in (notebook, done))
    if code(here) != code(there):
        raise Stop(f"{path.name} was changed while the book was built; build it again.")
    common = stock(folder)
    for cell, run_before in zip(here, there, strict=True):
        stored = iter(cell["outputs"] if VARIES in tags(cell) else ())
        shown = [out if normalise.is_picture(out) else next(stored, out) for out in run_before["outputs"]]
        cell["outputs"] = list(scenes.as_html(shown, common))
    return notebook


def kept(path, folder=FOLDER):
    return folder / path.name


def stock_of(folder=FOLDER):
    return folder / "stock"


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
    """A hash of environment.txt, of every file of `omx`, and of what draws a scene for paper."""
    files = [p for p in sorted((ROOT / "omx").rglob("*")) if p.is_file() and "__pycache__" not in p.parts]
    digest = hashlib.sha256(ENVIRONMENT.read_bytes())
    for path in (*files, ROOT / "book/publish/still_picture.py"):
        digest.update(str(Path(path).relative_to(ROOT)).encode() + path.read_bytes())
    return digest.hexdigest()
