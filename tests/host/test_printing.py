"""Printed markers are true to scale: measured in the files, not through the code that wrote them."""

import io
import math
import pathlib
import struct
import xml.etree.ElementTree as ElementTree

import cv2
import numpy as np
import pypdf
import pytest

from larics import marker
from larics_host import cli
from larics_host.printing import layout

POINT_MM = 25.4 / 72
# what the default marker measures: rings (radius, width), lines (angle, start, end, width), mm
RINGS = [(100.0, 20.0), (150.0, 20.0)]
ORIENTATION = (0, 150.0, 230.0, 20.0)
CODE = {4: (90, 25.0, 80.0, 20.0), 2: (180, 25.0, 80.0, 20.0), 1: (270, 25.0, 80.0, 20.0)}


def larics(*argv):
    return cli.main(["marker", *map(str, argv)])


def expected_lines(marker_id, scale=1.0):
    lines = [ORIENTATION] + [line for bit, line in CODE.items() if marker_id & bit]
    return sorted((angle, *(round(value * scale, 1) for value in sizes)) for angle, *sizes in lines)


class PdfPage:
    """Strokes of a PDF page in page millimetres, from its content stream."""

    def __init__(self, page):
        self.width, self.height = (float(value) * POINT_MM for value in page.mediabox[2:])
        self.circles, self.segments, self.clips, self.texts = [], [], [], []
        state = (np.eye(3), 1.0)
        stack, path, rectangle, text_font = [], [], None, 0.0
        for operands, operator in pypdf.generic.ContentStream(page.get_contents(), page.pdf).operations:
            values = [float(v) if isinstance(v, (int, float)) else v for v in operands]
            matrix, width = state
            if operator == b"q":
                stack.append(state)
            elif operator == b"Q":
                state = stack.pop()
            elif operator == b"cm":
                a, b, c, d, e, f = values
                state = (np.array([[a, b, 0], [c, d, 0], [e, f, 1]]) @ matrix, width)
            elif operator == b"w":
                state = (matrix, values[0])
            elif operator in (b"m", b"l"):
                path.append(self.place(values, matrix))
            elif operator == b"c":
                path.append(self.place(values[4:], matrix))
            elif operator == b"re":
                x, y, w, h = values
                rectangle = (*self.place((x, y), matrix), *self.place((x + w, y + h), matrix))
            elif operator in (b"W", b"W*"):
                self.clips.append(rectangle)
            elif operator == b"n":
                path = []
            elif operator in (b"S", b"s"):
                width_mm = width * math.hypot(matrix[0, 0], matrix[0, 1]) * POINT_MM
                self.add(path, width_mm)
                path = []
            elif operator == b"Tf":
                text_font = values[1]
            elif operator == b"Tj":
                self.texts.append((str(operands[0]), text_font))

    @staticmethod
    def place(point, matrix):
        x, y, _ = np.array([*point, 1.0]) @ matrix
        return x * POINT_MM, y * POINT_MM

    def add(self, path, width):
        if len(path) == 2:
            self.segments.append((*path[0], *path[1], width))
            return
        points = np.array(path)
        low, high = points.min(axis=0), points.max(axis=0)
        center = (low + high) / 2
        assert np.allclose(np.hypot(*(points - center).T), (high - low)[0] / 2, atol=0.01)
        self.circles.append((*center, (high - low)[0] / 2, width))

    def ruler(self):
        """Length of the longest hairline and the heights of the ticks that stand on it."""
        x1, y1, x2, y2, _ = max(
            (s for s in self.segments if s[4] < 0.3 and s[1] == s[3]), key=lambda s: abs(s[2] - s[0])
        )
        ticks = [s for s in self.segments if s[0] == s[2] and abs(s[1] - y1) < 0.001 and s[3] > s[1]]
        return abs(x2 - x1), len(ticks)


def read_pdf(path):
    return [PdfPage(page) for page in pypdf.PdfReader(path).pages]


def measure(circles, segments):
    """Black rings and radial lines around the centre of the rings."""
    rings = [circle for circle in circles if circle[3] > 0.3]
    x, y = rings[0][:2]
    assert all(math.hypot(ring[0] - x, ring[1] - y) < 0.01 for ring in rings)
    lines = []
    for x1, y1, x2, y2, width in segments:
        if width > 0.3:
            start, end = math.hypot(x1 - x, y1 - y), math.hypot(x2 - x, y2 - y)
            angle = math.degrees(math.atan2(y2 - y, x2 - x)) % 360
            assert abs((math.degrees(math.atan2(y1 - y, x1 - x)) - angle + 180) % 360 - 180) < 0.01
            lines.append((round(angle) % 360, start, end, width))
    return (x, y), sorted(ring[2:] for ring in rings), sorted(lines)


def assert_measures(circles, segments, marker_id, scale=1.0):
    center, rings, lines = measure(circles, segments)
    wanted = [tuple(round(value * scale, 1) for value in ring) for ring in RINGS]
    assert np.allclose(rings, wanted, atol=0.01)
    assert [line[0] for line in lines] == [line[0] for line in expected_lines(marker_id)]
    assert np.allclose(lines, expected_lines(marker_id, scale), atol=0.01)
    return center


@pytest.mark.parametrize("marker_id", range(1, 8))
def test_pdf_in_one_piece(tmp_path, marker_id):
    path = tmp_path / "m.pdf"
    assert larics(marker_id, "-o", path, "--paper", "plate") == 0
    (page,) = read_pdf(path)
    x, y = assert_measures(page.circles, page.segments, marker_id)
    assert abs(x - page.width / 2) < 0.01 and y > 250
    plate = [circle for circle in page.circles if circle[3] <= 0.3]
    assert len(plate) == 1 and abs(plate[0][2] - 250) < 0.01
    assert page.ruler() == (pytest.approx(100, abs=0.01), 21)
    texts = [text for text, _ in page.texts]
    assert "ID %d" % marker_id in texts and any("100 %" in text for text in texts)


def test_pdf_tiles_fit_together(tmp_path):
    path = tmp_path / "m.pdf"
    assert larics(5, "-o", path) == 0
    pages = read_pdf(path)
    assert len(pages) == 6
    centers, corners = [], []
    for page in pages:
        assert sorted((page.width, page.height)) == pytest.approx([210, 297], abs=0.01)
        assert page.ruler() == (pytest.approx(100, abs=0.01), 21)
        centers.append(assert_measures(page.circles, page.segments, 5))
        left, bottom, right, top = page.clips[0]
        assert left >= 5 and bottom >= 15 and right <= page.width - 5 and top <= page.height - 5
        x, y = centers[-1]
        corners.append((left - x, bottom - y, right - x, top - y))
    # in the marker's own coordinates the windows cover the plate and its crop marks without a gap
    points = np.random.default_rng(1).uniform(-257, 257, (4000, 2))
    covered = [any(a <= px <= c and b <= py <= d for a, b, c, d in corners) for px, py in points]
    assert all(covered)
    # neighbours overlap by 10 mm
    columns = sorted({(round(a, 3), round(c, 3)) for a, _, c, _ in corners})
    assert len(columns) == 3
    assert all(columns[i][1] - columns[i + 1][0] == pytest.approx(10) for i in range(2))


def test_cut_marks_of_neighbours_lie_on_each_other(tmp_path):
    path = tmp_path / "m.pdf"
    assert larics(2, "-o", path) == 0
    marks = []
    for page in read_pdf(path):
        (x, _), _, _ = measure(page.circles, page.segments)
        bottom = page.clips[0][1]
        upright = [s for s in page.segments if s[0] == s[2] and bottom - s[1] == pytest.approx(1.0)]
        marks.append([s[0] - x for s in upright])
    for row in (0, 3):
        left, middle, right = marks[row : row + 3]
        assert (len(left), len(middle), len(right)) == (1, 2, 1)
        assert left[0] == pytest.approx(min(middle), abs=0.001)
        assert right[0] == pytest.approx(max(middle), abs=0.001)


def test_labels_tell_the_tiles_apart(tmp_path):
    path = tmp_path / "m.pdf"
    assert larics(7, "-o", path, "--paper", "a3") == 0
    pages = read_pdf(path)
    labels = [text for page in pages for text, _ in page.texts if "row" in text]
    assert len(labels) == len(set(labels)) == len(pages) == 4
    assert sorted((page.width, page.height) for page in pages)[0] == pytest.approx((297, 420), abs=0.01)


def test_small_markers_take_a_page_each(tmp_path):
    path = tmp_path / "m.pdf"
    assert larics(1, 6, "-o", path, "--radius-mm", 30) == 0
    pages = read_pdf(path)
    assert len(pages) == 2
    for page, marker_id in zip(pages, (1, 6), strict=True):
        center = assert_measures(page.circles, page.segments, marker_id, 0.2)
        assert center[0] == pytest.approx(page.width / 2, abs=0.01)
        assert not any("row" in text for text, _ in page.texts)


def test_pdf_is_the_same_each_time_and_asks_for_no_scaling(tmp_path):
    for name in ("a.pdf", "b.pdf"):
        assert larics(3, "-o", tmp_path / name) == 0
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()
    catalog = pypdf.PdfReader(tmp_path / "a.pdf").trailer["/Root"]
    assert catalog["/ViewerPreferences"]["/PrintScaling"] == "/None"


def read_svg(path):
    root = ElementTree.parse(path).getroot()
    width, height = (float(root.get(name).removesuffix("mm")) for name in ("width", "height"))
    assert [float(value) for value in root.get("viewBox").split()] == [0, 0, width, height]
    space = "{http://www.w3.org/2000/svg}"
    circles, segments = [], []
    for node in root.iter(space + "circle"):
        cx, cy, r, w = (float(node.get(name)) for name in ("cx", "cy", "r", "stroke-width"))
        circles.append((cx, height - cy, r, w))
    for node in root.iter(space + "line"):
        x1, y1, x2, y2, w = (float(node.get(name)) for name in ("x1", "y1", "x2", "y2", "stroke-width"))
        segments.append((x1, height - y1, x2, height - y2, w))
    return circles, segments, [node.text for node in root.iter(space + "text")]


@pytest.mark.parametrize("radius_mm", [150, 7.5, 333.3])
def test_svg_geometry(tmp_path, radius_mm):
    path = tmp_path / "m.svg"
    assert larics(6, "-o", path, "--radius-mm", radius_mm) == 0
    circles, segments, texts = read_svg(path)
    _, rings, lines = measure(circles, segments)
    # lengths are multiples of 0.1 mm in proportion to the radius
    scale = radius_mm / 150
    assert np.allclose(rings, np.array(RINGS) * scale, atol=0.0501)
    assert rings[1][0] == pytest.approx(radius_mm, abs=0.01)
    wanted = [(angle, *(value * scale for value in sizes)) for angle, *sizes in expected_lines(6)]
    assert np.allclose(lines, wanted, atol=0.0501)
    assert "ID 6" in texts
    ruler = [abs(s[2] - s[0]) for s in segments if s[4] < 0.3 and s[1] == s[3]]
    assert max(ruler) == pytest.approx(100, abs=0.01)


def test_line_width_and_id_0_are_options(tmp_path):
    path = tmp_path / "m.svg"
    assert larics(0, "-o", path, "--line-mm", 15, "--allow-id0") == 0
    circles, segments, _ = read_svg(path)
    _, rings, lines = measure(circles, segments)
    assert rings == [(100.0, 15.0), (150.0, 15.0)]
    assert lines == [(0, 150.0, 230.0, 15.0)]


def test_several_ids_as_svg_or_png_are_one_file_each(tmp_path, capsys):
    assert larics(1, 2, "-o", tmp_path / "m.svg") == 0
    assert larics(4, 7, "-o", tmp_path / "p.png", "--dpi", 30) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m-1.svg", "m-2.svg", "p-4.png", "p-7.png"]
    assert capsys.readouterr().out.count("wrote ") == 4
    assert "ID 2" in read_svg(tmp_path / "m-2.svg")[2]


def expected_black(x, y, marker_id):
    """Signed distance in mm to the black of the default marker, negative inside; centre at (0, 0)."""
    radius = np.hypot(x, y)
    distance = np.minimum(abs(radius - 150), abs(radius - 100)) - 10
    for angle, start, end, width in expected_lines(marker_id):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        along, across = x * c + y * s, abs(y * c - x * s)
        line = np.maximum(np.maximum(start - along, along - end), across - width / 2)
        distance = np.minimum(distance, line)
    return distance


@pytest.mark.parametrize("marker_id", [1, 4, 6])
def test_png_pixels(tmp_path, marker_id):
    path = tmp_path / "m.png"
    assert larics(marker_id, "-o", path, "--dpi", 101.6) == 0  # 4 px per mm
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert image.dtype == np.uint8 and image.ndim == 2
    data = path.read_bytes()
    at = data.index(b"pHYs") + 4
    assert struct.unpack(">IIB", data[at : at + 9]) == (4000, 4000, 1)  # pixels per metre
    height, width = image.shape
    center_x = width / 2 / 4
    center_y = 10 + 7 + 250  # margin, crop marks, plate
    x = (np.arange(width) + 0.5) / 4 - center_x
    y = center_y - (np.arange(height)[:, None] + 0.5) / 4
    distance = expected_black(x, y, marker_id)
    inside = np.hypot(x, y) < 245
    assert (image[inside & (distance < -0.2)] == 0).all()
    assert (image[inside & (distance > 0.2)] == 255).all()
    # the grey of edge pixels puts the edge where it belongs: ring width along a ray off the axes
    for angle in (0.6, 2.0, 3.9, 5.0):
        t = np.arange(80, 170, 0.05)
        px = (center_x + t * math.cos(angle)) * 4 - 0.5
        py = (center_y - t * math.sin(angle)) * 4 - 0.5
        ray = cv2.remap(image, px.astype(np.float32), py.astype(np.float32), cv2.INTER_LINEAR)
        dark = (255 - ray.astype(float).ravel()) / 255
        assert dark[t < 125].sum() * 0.05 == pytest.approx(20, abs=0.03)
        assert (dark * t)[t >= 125].sum() / dark[t >= 125].sum() == pytest.approx(150, abs=0.02)


@pytest.mark.parametrize(
    "argv, part",
    [
        (["0", "-o", "m.pdf"], "unknown marker ID 0"),
        (["8", "-o", "m.svg"], "unknown marker ID 8"),
        (["-1", "-o", "m.svg"], "unknown marker ID -1"),
        (["3", "-o", "m.gif"], ".pdf, .svg, .png"),
        (["3", "-o", "m"], ".pdf, .svg, .png"),
        (["3", "-o", "m.pdf", "--radius-mm", "0"], "--radius-mm 0"),
        (["3", "-o", "m.pdf", "--radius-mm", "-5"], "--radius-mm -5"),
        (["3", "-o", "m.pdf", "--radius-mm", "nan"], "--radius-mm nan"),
        (["3", "-o", "m.pdf", "--radius-mm", "20.05"], "0.1 mm"),
        (["3", "-o", "m.pdf", "--radius-mm", "1500"], "pages"),
        (["3", "-o", "m.pdf", "--radius-mm", "1600", "--paper", "plate"], "page"),
        (["3", "-o", "m.pdf", "--line-mm", "60"], "--line-mm 60"),
        (["3", "-o", "m.pdf", "--line-mm", "0"], "--line-mm 0"),
        (["3", "-o", "m.pdf", "--paper", "a5"], "a5"),
        (["3", "-o", "m.svg", "--paper", "a4"], "--paper"),
        (["3", "-o", "m.pdf", "--dpi", "300"], "--dpi"),
        (["3", "-o", "m.png", "--dpi", "-3"], "--dpi"),
        (["3", "-o", "m.png", "--dpi", "9000"], "too large"),
        (["3", "-o", "nowhere/m.pdf"], "cannot write nowhere/m.pdf"),
    ],
)
def test_bad_input_is_one_line(argv, part, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert larics(*argv) == 2
    said = capsys.readouterr().err
    assert said.startswith("larics: ") and said.count("\n") == 1 and part in said
    assert not list(pathlib.Path(tmp_path).iterdir())


def test_every_radius_on_offer_has_a_geometry():
    for outer_mm10 in range(50, 20001, 7):
        assert marker.LARICS3.scaled(outer_mm10).strokes(7)


def test_the_marker_of_id_7_has_all_its_lines_in_the_pdf_stream():
    buffer = io.BytesIO()
    from larics_host.printing import layout
    from larics_host.printing.pdf import pdf_bytes

    buffer.write(pdf_bytes([layout.plate_sheet(marker.LARICS3, 7)], "t"))
    (page,) = read_pdf(buffer)
    assert len([s for s in page.segments if s[4] > 0.3]) == 4


@pytest.mark.parametrize("paper", sorted(layout.PAPERS_MM))
@pytest.mark.parametrize("radius_mm10", [300, 1500])
def test_every_paper_and_its_ruler_survives_another_format(paper, radius_mm10):
    family = marker.LARICS3.scaled(radius_mm10, 0, False)
    for sheet in layout.paper_sheets(family, 3, paper):
        assert sorted((sheet.width, sheet.height)) == list(layout.PAPERS_MM[paper])
        lines = [one for one in sheet.furniture if isinstance(one, layout.Line)]
        (ruler,) = [one for one in lines if abs(one.x2 - one.x1 - layout.RULER_MM) < 1e-6]
        # A4 centred on Letter loses 8.8 mm at the bottom, and printers leave 4.2 mm there
        assert ruler.y1 >= (297.0 - 279.4) / 2 + 4.2
        assert any("print at 100 %" in one.text for one in sheet.furniture if isinstance(one, layout.Text))


def test_a_file_that_is_there_is_overwritten_only_when_told(tmp_path, capsys):
    (tmp_path / "m-5.svg").write_text("mine")
    argv = ["marker", "3", "5", "-o", str(tmp_path / "m.svg")]
    assert cli.main(argv) == 2
    assert "m-5.svg exists: choose another name, or --force" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["m-5.svg"]  # and nothing was begun
    assert cli.main([*argv, "--force"]) == 0
    assert (tmp_path / "m-5.svg").read_text() != "mine"


def test_us_paper(tmp_path):
    for paper, size in (("letter", (612, 792)), ("legal", (612, 1008)), ("tabloid", (792, 1224))):
        path = tmp_path / (paper + ".pdf")
        assert cli.main(["marker", "3", "--radius-mm", "30", "--paper", paper, "-o", str(path)]) == 0
        box = pypdf.PdfReader(path).pages[0].mediabox
        assert sorted((float(box.width), float(box.height))) == pytest.approx(size, abs=0.1)


@pytest.mark.parametrize("outer_mm10", [200, 300, 500, 1500, 2500])
def test_id_and_scale_stay_on_the_cut_out_square_and_off_the_plate(outer_mm10):
    family = marker.CODED.scaled(outer_mm10)
    items = layout.marker_content(family, 1234)
    plate = family.plate_mm10 / 10
    texts = [item for item in items if isinstance(item, layout.Text)]
    middle = layout.content_side_mm(family) / 2
    assert [text.text.split(",")[0] for text in texts] == ["ID 1234", "print at 100 %"]
    for text in texts:
        wide = 0.55 * text.size * len(text.text)  # no letter of the font is wider on average
        left = text.x - wide if text.anchor == "end" else text.x
        box = (left - middle, text.y - middle, left + wide - middle, text.y + text.size - middle)
        assert max(map(abs, box)) < plate
        near = min(abs(box[0]), abs(box[2])), min(abs(box[1]), abs(box[3]))
        assert math.hypot(*near) > plate
