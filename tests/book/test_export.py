"""`python run.py export`: the arm's URDF, where it is asked for."""

import omx
from book.reader import export


def test_the_urdf_is_written_where_it_is_asked_for(tmp_path, capsys):
    path = tmp_path / "new" / "arm.urdf"
    assert export.main(["urdf", "--maker", "--maker-base", "--to", str(path)]) == 0
    assert path.read_text(encoding="utf-8") == omx.urdf.text(omx.MAKER, maker_base=True)
    assert str(path) in capsys.readouterr().out


def test_a_place_that_cannot_be_is_named(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert export.main(["--to", str(tmp_path / "file" / "arm.urdf")]) == 1
    assert "file is in the way" in capsys.readouterr().err
    assert export.main(["--to", str(tmp_path)]) == 1
    assert f"run.py: cannot write {tmp_path}" in capsys.readouterr().err
