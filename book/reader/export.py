"""The arm as a file for other programs: `python run.py export urdf [--maker] [--maker-base] [--to FILE]`."""

import argparse
import sys
from pathlib import Path

import omx
from book.setup.paths import ROOT, in_a_sentence


@in_a_sentence
def main(argv):
    parser = argparse.ArgumentParser("python run.py export", description="Write the arm as a file for other programs.")
    parser.add_argument("kind", nargs="?", default="urdf", choices=["urdf"], help="urdf: ROS, MuJoCo and others")
    parser.add_argument("--maker", action="store_true", help="the maker's lengths instead of the book's own")
    parser.add_argument("--maker-base", action="store_true", help="its base where the maker's is, 12 mm further back")
    parser.add_argument("--to", type=Path, default=ROOT / "build" / "openmanipulator-x.urdf", help="the file to write")
    asked = parser.parse_args(argv)
    try:
        asked.to.parent.mkdir(parents=True, exist_ok=True)
        path = omx.urdf.write(asked.to, omx.MAKER if asked.maker else omx.COURSE, maker_base=asked.maker_base)
    except omx.BadInput as error:
        print(f"run.py: {error}", file=sys.stderr)
        return 1
    print(f"{path.resolve()}\nHow to open it in other programs: book/files.md")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
