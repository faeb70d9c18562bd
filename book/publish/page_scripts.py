"""The scripts that pages, decks and hand-ins load: MathJax, 3-D viewer, panels, the kinematics in JavaScript."""

from pathlib import Path

from book.publish import scenes
from book.setup.paths import BUILD, ROOT, Stop

SHARED = BUILD / "shared"
LIVE = ROOT / "omx/display/panels/live_figure.css"
AGAIN = Path(__file__).with_name("derive_again.py")
GENERATED = ("fk", "ik", "jacobian")


def share(libraries, common, folder=SHARED):
    """What every page loads, from npm and from `omx`: MathJax, the 3-D viewer, the kinematics in JavaScript.

    `common`: the objects that several scenes hold (`runs.stock`).
    """
    (folder / "mathjax").mkdir(parents=True, exist_ok=True)
    update(folder / "mathjax" / "tex-svg-full.js", (libraries / "mathjax/es5/tex-svg-full.js").read_bytes())
    update(folder / "omx-kinematics.js", kinematics().encode())
    update(folder / "omx-view.js", scenes.page_script(common).encode())
    update(folder / "omx-panels.js", panels().encode())
    update(folder / LIVE.name, LIVE.read_bytes())
    update(folder / AGAIN.name, AGAIN.read_bytes())


def update(path, data):
    """Write the file if its bytes change, so that Sphinx sees what is new."""
    if not path.exists() or path.read_bytes() != data:
        path.write_bytes(data)


def panels():
    """The scripts of panels and live figures as one."""
    from omx.display.panels import live_figure

    return live_figure.script()


def kinematics():
    """The generated modules as one plain script. Raises `Stop` where a chapter has not written its own."""
    from omx.display.viewer import assets

    for name in GENERATED:
        if not (ROOT / "omx" / "generated" / f"{name}.js").exists():
            raise Stop(f"omx/generated/{name}.js is missing; `python run.py generate` writes it from the notebooks.")
    return assets.kinematics()
