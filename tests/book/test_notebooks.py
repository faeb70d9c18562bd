"""The notebooks write the generated modules, byte for byte; nbval compares their outputs beside this file."""

import shutil

import pytest

from book.chapters import generate, normalise
from book.publish import runs

CHAPTERS = sorted(normalise.NOTEBOOKS.glob("*.ipynb"))
WRITERS = sorted(set(generate.sources().values()))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A folder with all that the writing chapters write. tests/browser/test_chapters.py has another hash seed's."""
    folder = tmp_path_factory.mktemp("generated")
    for path in runs.run_all([normalise.NOTEBOOKS / f"{name}.ipynb" for name in WRITERS]):
        shutil.copytree(runs.generated(path), folder, dirs_exist_ok=True)
    return folder


def checked_in():
    return {path.name for module in generate.sources() for path in module.parent.glob(module.stem + ".*")}


def test_every_generated_module_names_its_chapter():
    unnamed = {p.name for p in generate.GENERATED.glob("*.py")} - {p.name for p in generate.sources()} - {"__init__.py"}
    assert not unnamed
    assert [path.stem for path in CHAPTERS if path.stem in WRITERS] == WRITERS, "a chapter named in a header is missing"


def test_notebooks_write_what_is_checked_in(written):
    names = {path.name for path in written.iterdir() if path.is_file()}
    assert names == checked_in(), f"the set of generated files has changed; to write them: {generate.FIX}"
    difference = generate.difference(written)
    assert not difference, f"{difference}\nThe notebooks write other modules now. To store them: {generate.FIX}"


def test_the_comparison_can_fail(tmp_path):
    for path in generate.GENERATED.iterdir():
        if path.name in checked_in():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    assert generate.difference(tmp_path) == ""
    fk = tmp_path / "fk.py"
    fk.write_bytes(fk.read_bytes() + b"\n")
    assert "fk.py" in generate.difference(tmp_path)
    fk.unlink()
    assert "fk.py" in generate.difference(tmp_path)
