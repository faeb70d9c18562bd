"""The printed mat of the lab lies true: a millimetre is a millimetre, and its places are those of the chapter."""

import re
from xml.etree import ElementTree

import pytest

from book.chapters import normalise
from book.chapters.cells import source
from book.setup.paths import ROOT

MAT = ROOT / "book" / "static" / "table-mat.svg"
SVG = "{http://www.w3.org/2000/svg}"


def test_the_mat_is_drawn_in_millimetres_about_the_axis():
    root = ElementTree.parse(MAT).getroot()
    _, _, width, height = map(float, root.get("viewBox").split())
    assert (root.get("width"), root.get("height")) == (f"{width:g}mm", f"{height:g}mm") == ("420mm", "297mm")
    axis = next(root.iter(f"{SVG}circle"))
    x0, y0 = float(axis.get("cx")), float(axis.get("cy"))
    drawn = {}
    for cross in (path.get("d") for path in root.iter(f"{SVG}path")):
        if found := re.match(r"M(\S+) (\S+) h6 ", cross):
            x, y = float(found[1]) + 3, float(found[2])
            drawn[(round(y0 - y, 1), round(x0 - x, 1))] = True
    cells = [source(cell) for cell in normalise.read(next(normalise.NOTEBOOKS.glob("*-pick-and-place.ipynb")))["cells"]]
    code = next(text for text in cells if "places = {" in text)
    places = re.findall(r"\((\d+), (-?\d+)\)", code.split("places = ")[1].split("}")[0])
    assert len(places) == 3
    for x, y in places:
        assert (float(x), float(y)) in drawn, (x, y)
    rings = {float(found) for found in re.findall(r"A(\d+) \d+ 0 1 1", MAT.read_text())}
    assert rings >= {60.0, 190.0}
    for ring in re.finditer(r"M(\S+) (\S+) A(\d+)", MAT.read_text()):
        x, y, radius = map(float, ring.groups())
        assert ((x - x0) ** 2 + (y - y0) ** 2) ** 0.5 == pytest.approx(radius, abs=0.01)
