"""Makes a ROS 2 prefix, such as .venv, know the package of this checkout: `python .ci/ament_index.py PREFIX`.

pip's editable installation leaves out what colcon would install: the marker of the ament index, share/bearing_twin with
launch files and parameters, and the nodes where `ros2 run` looks. All are links into the checkout.
"""

import os
import sys
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent
PACKAGE = "bearing_twin"


def main(prefix: Path) -> None:
    """Writes the links, again where they are there already."""
    link(CHECKOUT / "resource" / PACKAGE, prefix / "share" / "ament_index" / "resource_index" / "packages" / PACKAGE)
    share = prefix / "share" / PACKAGE
    if (share / "launch").is_symlink():  # as earlier versions had it
        (share / "launch").unlink()
    # `ros2 launch` does not follow a link to a folder.
    for name in ("package.xml", "config", *(str(one.relative_to(CHECKOUT)) for one in CHECKOUT.glob("launch/*.py"))):
        link(CHECKOUT / name, share / name)
    for program in (prefix / "bin").glob("*_node"):
        link(program, prefix / "lib" / PACKAGE / program.name)


def link(target: Path, place: Path) -> None:
    """A symbolic link at `place`, whatever stood there before."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if place.is_symlink() or place.exists():
        place.unlink()
    place.symlink_to(os.path.relpath(target, place.parent.resolve()))


if __name__ == "__main__":
    main(Path(sys.argv[1]).absolute())
