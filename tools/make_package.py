"""Writes package.json, by which `mpremote mip install` puts the firmware into a board's library.

python tools/make_package.py            after adding, renaming or removing a file of shared/ or firmware/
"""

import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "shared"), str(ROOT / "host")]

from larics import __version__  # noqa: E402
from larics_host.flash import build  # noqa: E402

TARGET = ROOT / "package.json"


def package():
    """The text of package.json."""
    urls = [
        [name[: -len(".mpy")] + ".py", path.relative_to(ROOT).as_posix()]
        for path, name in build.program(ROOT)
    ]
    return json.dumps({"urls": urls, "deps": [], "version": __version__}, indent=1) + "\n"


if __name__ == "__main__":
    TARGET.write_text(package())
    print("package.json: %d files" % len(build.program(ROOT)))
