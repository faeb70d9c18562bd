"""A line of a chapter changed on its page: derived again by the browser edition's Python, or answered without it."""

import inspect
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import omx
from book.publish import lite, runs, site
from book.setup import extra_envs
from book.setup.paths import Stop
from omx.derive import write_chain
from omx.derive.store import GENERATED
from tests.browser.weblook import Look, serious, served

PATIENCE_MS = 240_000
DERIVED = ".omx-said:text-matches('^Derived again')"


def copied(built_site, folder):
    """A copy of the site, without the browser edition that somebody may have laid into it."""
    shutil.copytree(built_site, folder, ignore=lambda at, _: [site.LITE] if Path(at) == built_site else [])
    return folder


@pytest.fixture(scope="module")
def motion():
    return "reduce"  # no film is looked at


@pytest.fixture(scope="module")
def home(built_site, tmp_path_factory):
    """The site around what the browser edition has of Python, without JupyterLab."""
    folder = copied(built_site, tmp_path_factory.mktemp("with") / "site")
    try:
        lite.lay_out_python(folder / site.LITE, extra_envs.python("lite"))
    except Stop as stop:
        pytest.skip(str(stop))
    site.finish(folder)
    with served(folder) as address:
        yield address


class Editor:
    """The lines that can be changed on a chapter's page, and the panel above them."""

    def __init__(self, look, name):
        self.look, self.page = look, look.page
        (path,) = [path for path in runs.chapters() if path.stem.endswith(name)]
        look.open(f"notebooks/{path.stem}.html").settle()
        self.box = self.page.locator(".omx-edit")
        self.panel = self.page.locator(".omx-panel").last
        self.frame = look.scene(self.panel.locator(".omx-scene"))

    def change(self, name, old, new):
        area = self.box.get_by_label(name, exact=False).first
        text = area.input_value()
        assert old in text
        area.fill(text.replace(old, new))

    def derive(self):
        self.box.get_by_role("button", name="Derive again").press("Enter")
        self.page.locator(DERIVED).wait_for(timeout=PATIENCE_MS)
        self.page.wait_for_timeout(500)

    def lines(self, name):
        return self.box.get_by_label(name, exact=False).first.input_value()

    def press(self, name):
        self.box.get_by_role("button", name=name).click()
        self.page.wait_for_timeout(600)

    def said(self):
        return self.box.get_by_role("status").inner_text()

    def written(self):
        """The modules' whole texts."""
        return self.box.locator(".omx-written details pre").evaluate_all("(all) => all.map((one) => one.textContent)")

    def q(self):
        return self.panel.evaluate("(box) => box.omxPanel.q")

    def drawn(self, node):
        """Where a node of the scene's arm stands, (4, 4), mm."""
        find = "omxScene.viewer.scene_tree.find(['meshcat', 'arm', i]).object"
        elements = f"(i) => {{ const o = {find}; o.updateMatrix(); return o.matrix.elements; }}"
        T = np.array(self.frame.evaluate(elements, str(node)), float).reshape(4, 4).T
        T[:3, 3] *= 1e3
        return T

    def length_of(self, node):
        """How far the drawing of a link reaches back along its x axis, mm."""
        return -1e3 * self.frame.evaluate(BACK_END, str(node))


BACK_END = """(i) => {
  const part = omxScene.viewer.scene_tree.find(["meshcat", "arm", i, "<object>"]).object;
  part.updateMatrixWorld(true);
  const back = new MeshCat.THREE.Matrix4().copy(part.parent.matrixWorld).invert(), ends = [];
  part.traverse((mesh) => {
    if (!mesh.isMesh) return;
    mesh.geometry.computeBoundingBox();
    ends.push(mesh.geometry.boundingBox.clone().applyMatrix4(mesh.matrixWorld).applyMatrix4(back).min.x);
  });
  return Math.min(...ends);
}"""


@pytest.fixture
def editor(look):
    return lambda name: Editor(look, name)


def test_a_length_is_derived_again_to_the_byte_and_the_scene_is_that_arm(editor):
    here = editor("forward-kinematics")
    book = (GENERATED / "fk.py").read_text(encoding="utf-8")
    here.change("lengths", "L4: 126", "L4: 160")
    here.page.wait_for_timeout(600)
    longer = omx.COURSE.replace(L4=160)
    assert "x = 308.0, y = 0.0, z = 204.8 mm" in here.said(), "at once, before any Python"
    assert here.drawn(4) == pytest.approx(longer.chain.fk(here.q()), abs=1e-6)
    pulled = here.length_of(4)
    here.derive()
    assert here.written() == [book.replace('"L4": 126.0', '"L4": 160.0')]
    assert [line.strip() for line in here.box.locator("del, ins").all_inner_texts()] == [
        '-     "L4": 126.0,', '+     "L4": 160.0,'
    ]  # fmt: skip
    assert here.drawn(4) == pytest.approx(longer.chain.fk(here.q()), abs=1e-6)
    assert abs(here.length_of(4) - pulled) < 25, "what was pulled for the moment had about the true length"
    here.frame.evaluate("(pose) => omxScene.tool.move(pose)", [240, 60, 160, -0.3])
    here.page.wait_for_timeout(900)
    assert omx.pose(here.q(), longer) == pytest.approx([240, 60, 160, -0.3], abs=1e-6), "the tool is that arm's"
    assert serious(here.page, ".omx-edit") == []
    here.change("lengths", "L4: 160", "L4: 0")
    here.box.get_by_label("lengths").press("Control+Enter")
    here.box.get_by_text("L4 = 0 mm makes no arm: every length must be more than 0. Nothing was written.").wait_for()
    assert here.drawn(4) == pytest.approx(longer.chain.fk(here.q()), abs=1e-6), "a refused arm leaves the last one"
    here.change("lengths", "L4: 0", "L4: 126")
    here.change("rows", "theta=0, d=0, a=L4", "theta=sp.pi / 6, d=0, a=L4")
    here.derive()
    assert "DHRow(pi/6, 0.0, L4, 0.0)" in here.written()[0]
    rows = [*omx.COURSE.chain.rows[:3], omx.DHRow(math.pi / 6, 0, 126, 0)]
    assert here.drawn(4) == pytest.approx(omx.Chain(rows).fk(here.q()), abs=1e-6)
    assert here.frame.get_by_role("button", name="Drag the tool").count() == 0, "its inverse is another chapter's"
    here.box.get_by_role("button", name="The book's arm").click()
    here.page.wait_for_timeout(500)
    assert here.drawn(4) == pytest.approx(omx.fk(here.q()), abs=1e-6)
    assert here.look.problems == []


def test_the_inverse_of_another_table_is_derived_and_drives_the_panel(editor):
    here = editor("inverse-kinematics")
    here.change("rows", "theta=0, d=0, a=L4", "theta=sp.pi / 9, d=0, a=L4")
    here.derive()
    rows = [*omx.COURSE.chain.rows[:3], omx.DHRow(math.pi / 9, 0, 126, 0)]
    chain, names = omx.Chain(rows), {}
    fk, ik = here.written()
    exec(ik, names)
    here.panel.get_by_role("slider", name="x in mm").fill("180")
    asked = here.panel.evaluate("(box) => box.omxPanel.pose")
    for q in names["branches"](*asked, *omx.COURSE.values)[:2]:
        T = chain.fk(q)
        assert [*T[:3, 3], math.asin(T[2, 0])] == pytest.approx(asked, abs=1e-6)
    assert chain.fk(here.q())[:3, 3] == pytest.approx(asked[:3], abs=1e-6)
    here.page.wait_for_timeout(500)
    assert here.drawn(4) == pytest.approx(chain.fk(here.q()), abs=1e-6)
    assert "DHRow(pi/9, 0.0, L4, 0.0)" in fk
    assert here.look.problems == []


def planar(*lengths):
    return omx.Chain([omx.DHRow(0, 0, a, 0) for a in lengths], name="three planar links")


def test_a_chain_becomes_another_and_a_row_more_is_a_slider_more(editor, tmp_path):
    here = editor("planar-arms")
    here.change("planar", "DHRow(0, 0, 100, 0)", "DHRow(0, 0, 150, 0)")
    here.derive()
    assert here.written() == [inspect.getsource(write_chain("planar", planar(200, 200, 150), folder=tmp_path))]
    assert here.drawn(3) == pytest.approx(planar(200, 200, 150).fk(here.q()), abs=1e-6)
    here.change("planar", "DHRow(0, 0, 150, 0)", "DHRow(0, 0, 150, 0), omx.DHRow(0, 0, 50, 0)")
    here.derive()
    assert here.panel.locator("input[type=range]").count() == 4
    here.panel.get_by_role("slider", name="q4").fill("90")
    here.page.wait_for_timeout(500)
    assert here.q()[3] == pytest.approx(math.pi / 2)
    assert here.drawn(4) == pytest.approx(planar(200, 200, 150, 50).fk(here.q()), abs=1e-6)
    assert here.look.problems == []


def test_a_six_joint_arms_table_is_derived_with_a_row_that_it_never_had(editor, tmp_path):
    here = editor("other-arms")
    here.change("stanford", "DHRow(0, d6, 0, 0)", "DHRow(0, d6, 40, up)")
    here.change("stanford", "d2: 100", "d2: 140")
    here.derive()
    d1, d2, d6 = lengths = sp.symbols("d1 d2 d6", positive=True)
    up = sp.pi / 2
    rows = [*stanford(d6, d1, d2, up)[:5], omx.DHRow(0, d6, 40, up)]
    arm = omx.Chain(rows, name="the Stanford arm")
    numbers = dict(zip(lengths, (100, 140, 100), strict=True))
    module = write_chain("stanford", arm, folder=tmp_path, parameters=numbers)
    assert here.written() == [inspect.getsource(module)]
    chain = omx.Chain([*stanford(100, 100, 140)[:5], omx.DHRow(0, 100, 40, math.pi / 2)])
    assert here.drawn(6) == pytest.approx(chain.fk(here.q()), abs=1e-6)
    assert here.panel.locator("input[type=range]").count() == 6
    assert here.look.problems == []


@pytest.fixture(scope="module")
def pages_alone(built_site, tmp_path_factory):
    folder = copied(built_site, tmp_path_factory.mktemp("without") / "site")
    site.finish(folder)
    with served(folder) as address:
        yield address


@pytest.fixture
def alone(pages_alone, context):
    """A page of a site that has no Python in it."""
    with Look(context, pages_alone) as look:
        yield look


def test_the_readers_arm_goes_along_to_the_next_page_and_the_books_comes_back(alone):
    here = Editor(alone, "forward-kinematics")
    here.change("lengths", "L4: 126", "L4: 160")
    here.page.wait_for_timeout(600)
    there, longer = Editor(alone, "inverse-kinematics"), omx.COURSE.replace(L4=160)
    there.page.wait_for_timeout(600)
    assert "L4: 160" in there.lines("lengths")
    assert there.said() == (
        "These lines are yours, as you left them in this tab: \u201cThe book's arm\u201d brings the shipped ones back."
    )
    assert omx.pose(there.q(), longer) == pytest.approx(there.panel.evaluate("(box) => box.omxPanel.pose"), abs=1e-6)
    assert there.drawn(4) == pytest.approx(longer.chain.frames(there.q())[4], abs=1e-6)
    there.change("rows", "theta=0, d=0, a=L4", "theta=sp.pi / 9, d=0, a=L4")
    there.page.wait_for_timeout(600)
    back = Editor(alone, "forward-kinematics")
    assert "sp.pi / 9" in back.lines("rows")
    assert "\u201cDerive again\u201d makes the scene above that arm." in back.said()
    back.press("The book's arm")
    assert back.drawn(4) == pytest.approx(omx.frames(back.q())[4], abs=1e-6)
    again = Editor(alone, "inverse-kinematics")
    assert again.said() == ""
    assert "L4: 126" in again.lines("lengths")
    assert again.drawn(4) == pytest.approx(omx.frames(again.q())[4], abs=1e-6)
    assert alone.problems == []


def test_without_python_other_numbers_answer_at_once(alone):
    here = Editor(alone, "inverse-kinematics")
    here.change("lengths", "L2: 130", "L2: 150")
    here.page.wait_for_timeout(600)
    longer = omx.COURSE.replace(L2=150)
    x, y, z = (f"{v:.1f}" for v in omx.pose(omx.ZERO, longer)[:3])
    assert here.said() == f"With these numbers the tool at zero is at x = {x}, y = {y}, z = {z} mm."
    asked = here.panel.evaluate("(box) => box.omxPanel.pose")
    assert omx.pose(here.q(), longer) == pytest.approx(asked, abs=1e-6)
    assert here.drawn(3) == pytest.approx(longer.chain.frames(here.q())[3], abs=1e-6)
    here.change("lengths", "L2: 150", "L2: 0")
    here.page.wait_for_timeout(600)
    assert here.said() == "L2 = 0 mm makes no arm: every length must be more than 0."
    here.box.get_by_role("button", name="The book's arm").click()
    here.page.wait_for_timeout(600)
    assert here.drawn(3) == pytest.approx(omx.frames(here.q())[3], abs=1e-6)
    for name, field, old, new, table in (
        (
            "planar-arms",
            "planar",
            "DHRow(0, 0, 100, 0)",
            "DHRow(0.5, 0, 150, 0)",
            [(0, 0, 200, 0)] * 2 + [(0.5, 0, 150, 0)],
        ),
        ("other-arms", "stanford", "d6: 100", "d6: 150", stanford(150, 100, 100)),
    ):
        here = Editor(alone, name)
        here.change(field, old, new)
        here.page.wait_for_timeout(600)
        assert "With these numbers the tool at zero" in here.said()
        assert here.drawn(len(table)) == pytest.approx(omx.Chain(table).fk(here.q()), abs=1e-6)
    assert alone.problems == []


def stanford(d6, d1, d2, up=math.pi / 2):
    rows = [(0, d1, 0, -up), (0, d2, 0, up), (0, 0, 0, 0, True), (0, 0, 0, -up), (0, 0, 0, up), (0, d6, 0, 0)]
    return [omx.DHRow(*row) for row in rows]


def test_without_python_one_sentence_says_where_a_table_is_derived_and_all_fits_a_phone(alone):
    alone.page.set_viewport_size({"width": 320, "height": 640})
    here = Editor(alone, "other-arms")
    here.change("stanford", "DHRow(0, d6, 0, 0)", "DHRow(0, d6, 0, up)")
    here.box.get_by_role("button", name="Derive again").click()
    here.box.get_by_text("No Python lies beside this page").wait_for()
    assert here.said().count(".") == 1
    assert alone.problems == [], "it knows, and looks nowhere"
    assert here.page.evaluate("document.documentElement.scrollWidth") <= 320
    assert all(button.bounding_box()["height"] >= 24 for button in here.box.get_by_role("button").all())
