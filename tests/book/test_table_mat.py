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


#: The 16 bits of the tags 0 to 9 of ArUco's dictionary 0 (4x4, 50 tags), row by row; 1 is white.
TAGS = (0xB532, 0x0F9A, 0x332D, 0x9946, 0x549E, 0x79CD, 0x9E2E, 0xC4F2, 0xFEDA, 0xCF56)


@pytest.mark.parametrize("number", range(len(TAGS)))
def test_a_printed_tag_has_its_size_its_white_border_and_its_bits(number):
    """OpenCV's own detector found all ten on the printed sheet, 40.0 and 20.0 mm wide."""
    root = ElementTree.parse(MAT.with_name("tags.svg")).getroot()
    assert (root.get("width"), root.get("height"), root.get("viewBox")) == ("210mm", "297mm", "0 0 210 297")
    parts = list(root)
    (path,) = (part for part in parts if part.get("id") == f"tag-{number}")
    x, y, side = map(float, re.match(r"M(\S+) (\S+)h(\S+?)v", path.get("d")).groups())
    assert side == (40 if number < 2 else 20)
    border = parts[parts.index(path) - 1]
    left, top, cut = (float(border.get(name)) for name in ("x", "y", "width"))
    assert min(x - left, y - top, left + cut - x - side, top + cut - y - side) >= side / 6, "a white module all round"
    assert number < 2 or cut == 30, "as wide as a cube"
    bits = 0
    for cell_x, cell_y in re.findall(r"zM(\S+) (\S+?)h", path.get("d")):
        column, row = (6 * (float(at) - start) / side - 1 for at, start in ((cell_x, x), (cell_y, y)))
        assert (column, row) == pytest.approx((round(column), round(row)), abs=0.01)
        bits |= 1 << (15 - 4 * round(row) - round(column))
    assert bits == TAGS[number]
