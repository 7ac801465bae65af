"""The coded family: its code against an independent one, its printing and its rendering."""

import math
import re

import numpy as np
import pytest
from PIL import Image

from larics.marker import CODED, LARICS3, golay
from larics.marker.far_apart import FAR_APART_DISTANCE, FAR_APART_IDS
from larics_host import cli, printing
from larics_host.detection.options import DetectionOptions
from larics_host.marker_ids import parse_ids, ranges_of
from larics_host.render import render_frame
from larics_host.validation import report

CENTRES_DEG = [90 * quarter + angle for quarter in range(4) for angle in (18.5, 27.5, 36.5, 53.5, 62.5, 71.5)]


@pytest.fixture
def larics(capsys):
    """Runs the command; returns its exit code and what it printed on both streams."""

    def run(*arguments):
        code = cli.main([str(argument) for argument in arguments])
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return run


def divided(message):
    """The word of a message by polynomial division: message, 11 bits of remainder, parity."""
    value = message << 11
    for bit in range(22, 10, -1):
        if value >> bit & 1:
            value ^= 0xC75 << (bit - 11)
    value |= message << 11
    return value << 1 | bin(value).count("1") & 1


def test_code_is_the_extended_golay_code():
    words = np.array([golay.word(i) for i in range(4096)], np.uint32)
    assert words.tolist() == [divided(i) for i in range(4096)]
    ones = np.array([bin(i).count("1") for i in range(4096)], np.uint8)
    apart = min(
        int((ones[(words ^ word) & 4095] + ones[(words ^ word) >> 12])[words != word].min()) for word in words
    )
    assert apart == golay.DISTANCE == 8


def test_every_two_ids_differ_in_eight_cells_and_those_far_apart_in_twelve():
    cells = {i: CODED.cells(i) for i in CODED.ids()}
    longer = np.array([mask for i, mask in cells.items() if i > 7], np.uint32)
    ones = np.array([bin(i).count("1") for i in range(4096)], np.uint8)
    for mask in (0, *longer.tolist()):
        differ = longer ^ np.uint32(mask)
        count = ones[differ & 4095] + ones[differ >> 12]
        assert count[longer != mask].min() >= 8
    assert all(CODED.has(i) and i > 7 for i in FAR_APART_IDS) and len(FAR_APART_IDS) == 41
    far = [0, *(cells[i] for i in FAR_APART_IDS)]
    least = min(bin(a ^ b).count("1") for i, a in enumerate(far) for b in far[:i])
    assert least == FAR_APART_DISTANCE == 12


def test_a_marker_seen_turned_by_a_cell_is_no_other():
    """Only the empty and the full word survive a slip by one cell, neither of which is an ID."""
    masks = {golay.cells(i) for i in range(4096)}
    slipped = [mask for mask in masks if ((mask << 1 | mask >> 23) & 0xFFFFFF) in masks]
    assert sorted(slipped) == [0, 0xFFFFFF]


def dark_cells(grey, centre, per_mm, turn_deg=0.0):
    """The cells that are dark in a picture, by looking at their middles."""
    dark = 0
    for cell, angle in enumerate(CENTRES_DEG):
        turned = math.radians(angle + turn_deg)
        x, y = centre[0] + 232 * per_mm * math.cos(turned), centre[1] - 232 * per_mm * math.sin(turned)
        dark |= int(grey[int(round(y)), int(round(x))] < 128) << cell
    return dark


@pytest.mark.parametrize("marker_id", [5, 1261, 4094])
def test_png_shows_the_cells(tmp_path, marker_id):
    (path,) = printing.write_markers(CODED, [marker_id], tmp_path / "m.png", dpi=50)
    grey = np.array(Image.open(path))
    # the dashed rim of the plate is not black; the marker is in the middle of the sheet, above the ruler
    rows, columns = np.nonzero(grey[: -int(20 * 50 / 25.4)] < 40)
    middle = (grey.shape[1] - 1) / 2, (rows.min() + rows.max()) / 2
    assert dark_cells(grey, middle, 50 / 25.4) == CODED.cells(marker_id)


def test_svg_and_pdf_have_an_arc_for_each_stroke(tmp_path):
    arcs = [stroke for stroke in CODED.strokes(1261) if stroke[0] == "arc"]
    (path,) = printing.write_markers(CODED, [1261], tmp_path / "m.svg")
    text = path.read_text()
    found = re.findall(
        r'd="M (\S+) (\S+) A 232 232 0 0 0 (\S+) (\S+)" stroke="#000000" stroke-width="24"', text
    )
    assert len(found) == len(arcs)
    middle = re.search(r'<circle cx="(\S+)" cy="(\S+)" r="150"', text)
    cx, cy = float(middle[1]), float(middle[2])
    for ends, arc in zip(found, arcs, strict=True):
        x1, y1, x2, y2 = (float(end) for end in ends)
        assert math.degrees(math.atan2(cy - y1, x1 - cx)) % 360 == pytest.approx(arc[1] / 100, abs=0.01)
        assert math.degrees(math.atan2(cy - y2, x2 - cx)) % 360 == pytest.approx(arc[2] / 100, abs=0.01)
    assert "smallest feature 20 mm" in text
    (path,) = printing.write_markers(CODED, [1261], tmp_path / "m.pdf", "plate")
    assert path.read_bytes().startswith(b"%PDF")


def test_a_sheet_holds_many_and_a_batch_is_one_file(tmp_path, larics):
    family = CODED.scaled(200)
    sheet = printing.layout.many_on_sheets(family, [1, 2, 9, 10, 11, 12, 13], "a4")
    assert len(sheet) == 2  # six of 81 mm fit a page
    texts = [item.text for page in sheet for item in page.content if hasattr(item, "text")]
    assert texts[::2] == ["ID 1", "ID 2", "ID 9", "ID 10", "ID 11", "ID 12", "ID 13"]
    assert texts[1::2] == ["print at 100 %, ring 20 mm"] * 7
    code, out, _ = larics("marker", "9-40", "-o", tmp_path / "all.pdf", "--radius-mm", "25", "--sheet")
    assert code == 0 and "28 markers, smallest printed feature 3.3 mm" in out


def test_ranges_name_what_there_is():
    assert parse_ids(["9-17", "3"]) == [9, 10, 11, 12, 13, 14, 15, 17, 3]
    assert ranges_of(parse_ids(["9-17", "1-3"])) == "1-3,9-17"
    assert parse_ids([ranges_of(CODED.ids())]) == list(CODED.ids())
    assert ranges_of([1, 2, 3, 14, 15, 17]) == "1-3,14-17"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["8"], "unknown marker ID 8: the coded family has IDs 1 to 7, and to 4094"),
        (["4095"], "unknown marker ID 4095: the coded family"),
        (["9", "--family", "plain"], "unknown marker ID 9: the plain family has IDs 1 to 7"),
        (["1", "--family", "golay"], "unknown family golay: use plain (IDs 1 to 7) or coded"),
        (["nine"], "nine is no ID"),
        (["1", "--sheet"], "does not fit a page of A4"),
        ([], "which ID?"),
    ],
)
def test_bad_ids_are_one_line_that_names_the_family(tmp_path, larics, arguments, words):
    code, _, err = larics("marker", *arguments, "-o", tmp_path / "m.pdf")
    assert code and err.count("\n") == 1 and words in err
    assert not list(tmp_path.iterdir())


def test_suggestion_prints_what_can_be_printed(larics):
    few, many = larics("marker", "--suggest", "5")[1], larics("marker", "--suggest", "100")[1]
    assert "at least 12 of 24 cells" in few and "plain: IDs 1 to 7" in few
    assert "at least 8 of 24 cells" in many and "plain" not in many.replace("plain marker", "")
    ids = re.search(r"allowed_ids (\S+)", many)[1]
    assert len(parse_ids([ids])) == 100
    assert "out of range" in larics("marker", "--suggest", "5000")[2]


def test_coded_frames_are_plain_ones_with_cells():
    plain, (truth,) = render_frame("sunny", 8, 3, noise=0, jpeg=0)
    coded, (with_cells,) = render_frame("sunny", 8, 3, noise=0, jpeg=0, family="coded")
    assert with_cells.id > 7 and with_cells.id % 8 == truth.id and LARICS3.has(truth.id)
    assert (with_cells.x_px, with_cells.heading_deg) == (truth.x_px, truth.heading_deg)
    level = coded.max() / 255.0
    dark = dark_cells(
        coded / level, (truth.x_px, truth.y_px), truth.radius_px / 150, turn_deg=truth.heading_deg
    )
    assert dark == CODED.cells(with_cells.id)
    rows, columns = np.nonzero(plain != coded)
    away = np.hypot(columns - truth.x_px, rows - truth.y_px) * 150 / truth.radius_px
    assert away.min() > 210 and away.max() < 255
    with pytest.raises(ValueError, match="unknown family"):
        render_frame("sunny", 8, 3, family="golay")


def test_a_mixed_building_is_read(tmp_path):
    """Plain and coded markers in one frame, several coded ones, and coded ones cut by the border."""
    options = DetectionOptions(radius_px=(25, 35))
    detector = options.make(360, 296)
    kinds = set()
    for preset, family, count in (("multi", "mixed", 6), ("multi", "coded", 2), ("border", "coded", 6)):
        read = seen = 0
        for index in range(count):
            frame, truths = render_frame(preset, 960, index, family=family)
            found = {d.marker_id: d for d in detector.detect(frame.reshape(-1)) if d.marker_id >= 0}
            for truth in truths:
                one = found.pop(truth.id, None)
                seen += truth.visible > 0.999
                if one is not None:
                    read += truth.visible > 0.999
                    assert math.hypot(one.x_q8 / 256 - truth.x_px, one.y_q8 / 256 - truth.y_px) < 1.0
            assert not found  # no ID that is not there
            kinds.add(tuple(sorted({truth.id > 7 for truth in truths})))
        assert read >= 0.9 * seen and seen, (preset, family, read, seen)
    assert (False, True) in kinds


def test_hundreds_of_ids_are_reported_by_their_mistakes():
    class Result:
        def matrix(self):
            ids = list(CODED.ids()[:300])
            counts = [[3 * (row == column) for column in ids] for row in ids]
            counts[10][11] = 2
            return ids, ids, counts

    text = report._matrix(Result())
    assert "300 IDs: 900 markers of 300 IDs read right" in text
    assert text.count("<tr>") == 2 and "<td>%d</td><td>2</td>" % CODED.ids()[11] in text


def test_no_other_turn_is_taken_where_the_plate_is_seen_in_a_shadow():
    """A board of the plate's tone hides the orientation line and seven cells, which then look white: the word
    of another turn fitted, whose orientation line would lie in a shadow."""
    frame, (truth,) = render_frame("harsh", 6520, 247, family="coded")
    for found in DetectionOptions(radius_px=(25, 35)).make(360, 296).detect(frame.reshape(-1)):
        assert found.marker_id in (-1, truth.id)
