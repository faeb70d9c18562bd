"""Site, slides and lite say whose work they carry, with the licences that this asks for."""

import json
import zipfile

import pytest

from book.publish import notices


@pytest.mark.parametrize("packages", [notices.SITE, notices.SLIDES])
def test_each_package_and_each_part_of_the_viewer_has_its_licence(packages, tmp_path):
    text = notices.write(tmp_path, packages).read_text(encoding="utf-8")
    parts = text.split("-" * 100)
    for name in (*packages, "three"):
        mine = [part for part in parts if part.strip().startswith(f"{name} ")]
        assert len(mine) == 1, name
        assert "copyright" in mine[0].lower() or "permission" in mine[0].lower()
    assert notices.write(tmp_path, packages).read_text(encoding="utf-8") == text


def test_npm_packages_bundles_and_wheels_are_found(tmp_path):
    library = tmp_path / "npm" / "mathjax"
    library.mkdir(parents=True)
    (library / "package.json").write_text('{"name": "mathjax", "version": "3.2.2", "license": "Apache-2.0"}')
    (library / "LICENSE").write_text("Apache License")
    lite = tmp_path / "lite"
    lite.mkdir()
    parts = [{"name": "react", "versionInfo": "18", "licenseId": "MIT", "extractedText": "MIT text"}]
    (lite / "third-party-licenses.json").write_text(json.dumps({"packages": parts}))
    with zipfile.ZipFile(lite / "six-1.0-py3-none-any.whl", "w") as wheel:
        wheel.writestr("six-1.0.dist-info/licenses/LICENSE", "of six")
    text = notices.write(lite, (), [library]).read_text(encoding="utf-8")
    for expected in ("mathjax 3.2.2: Apache-2.0\n\nApache License", "react 18: MIT\n\nMIT text", "six 1.0\n\nof six"):
        assert expected in text


def test_a_package_without_a_licence_stops_the_build(tmp_path):
    with pytest.raises(LookupError, match="no-such-package has no licence file"):
        notices.write(tmp_path, ("no-such-package",))
