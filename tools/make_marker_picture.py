"""Writes docs/families.png: a plain and a coded marker as they are printed, side by side."""

import io
import pathlib
import sys

import numpy as np
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "shared"), str(ROOT / "host")]

from larics.marker import CODED  # noqa: E402  (needs the path set above)
from larics_host.printing import layout, png  # noqa: E402

TARGET = ROOT / "docs" / "families.png"
IDS = (5, 1261)  # with the same coding lines
DPI = 16


def picture():
    """The two plates beside each other, grey."""
    plates = []
    for marker_id in IDS:
        sheet = layout.plate_sheet(CODED, marker_id)
        grey = np.asarray(Image.open(io.BytesIO(png.png_bytes(sheet, 4 * DPI))))
        side = grey.shape[1]
        plates.append(grey[:side, :])
    return Image.fromarray(np.hstack(plates)).reduce(4)


if __name__ == "__main__":
    picture().save(TARGET, optimize=True)
    print("wrote", TARGET)
