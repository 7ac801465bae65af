import pytest
from hypothesis import given
from hypothesis import strategies as st

from larics_host.errors import UserError
from larics_host.truth import COLUMNS, Truth, by_frame, read_truth, write_truth

SOME = Truth(
    frame="frame_000001.pgm",
    time_us=33333,
    id=5,
    x_px=100.25,
    y_px=80.5,
    heading_deg=271.125,
    radius_px=30.0,
    vehicle_x_mm=-1.5,
    vehicle_y_mm=2.0,
    vehicle_heading_deg=90.0,
    marker_x_mm=10.0,
    marker_y_mm=20.0,
    marker_heading_deg=0.5,
    offset_x_mm=18.0,
    offset_y_mm=-11.5,
    visible=0.75,
)
NONE = Truth(frame="frame_000002.pgm", time_us=66667, vehicle_x_mm=1.0, vehicle_y_mm=2.0)


def test_columns_are_the_published_ones():
    assert ",".join(COLUMNS) == (
        "frame,time_us,id,x_px,y_px,heading_deg,radius_px,vehicle_x_mm,vehicle_y_mm,vehicle_heading_deg,"
        "marker_x_mm,marker_y_mm,marker_heading_deg,offset_x_mm,offset_y_mm,visible"
    )


def test_what_is_written_is_read(tmp_path):
    write_truth(tmp_path / "truth.csv", [SOME, NONE])
    assert read_truth(tmp_path / "truth.csv") == [SOME, NONE]
    assert read_truth(tmp_path) == [SOME, NONE]  # the folder will do


@given(
    x=st.floats(-1e6, 1e6),
    y=st.floats(-1e6, 1e6),
    heading=st.floats(0, 360),
    offset=st.floats(-1e7, 1e7),
    marker_id=st.integers(0, 7),
)
def test_numbers_keep_a_hundred_thousandth_of_a_pixel(tmp_path_factory, x, y, heading, offset, marker_id):
    path = tmp_path_factory.mktemp("truth") / "t.csv"
    write_truth(path, [Truth('a,"b".pgm', 1, marker_id, x, y, heading, 30.0, offset_x_mm=offset)])
    (read,) = read_truth(path)
    assert read.frame == 'a,"b".pgm'
    assert read.id == marker_id
    assert (read.x_px, read.y_px) == (pytest.approx(x, abs=1e-5), pytest.approx(y, abs=1e-5))
    assert read.heading_deg == pytest.approx(heading, abs=1e-5)
    assert read.offset_x_mm == pytest.approx(offset, abs=1e-3)


def test_frames_without_a_marker_are_kept():
    frames = by_frame([SOME, SOME, NONE])
    assert list(frames) == ["frame_000001.pgm", "frame_000002.pgm"]
    assert [len(markers) for markers in frames.values()] == [2, 0]


def refusal(path):
    with pytest.raises(UserError) as caught:
        read_truth(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_bad_files_are_refused_in_one_line(tmp_path):
    assert "cannot read" in refusal(tmp_path / "absent.csv")
    path = tmp_path / "t.csv"
    path.write_text("")
    assert "is empty" in refusal(path)
    path.write_text(",".join(COLUMNS[1:]) + "\n")
    assert "column frame is missing" in refusal(path)
    write_truth(path, [SOME])
    whole = path.read_text()
    for number in ("ten", "nan", "1e999"):
        path.write_text(whole.replace("100.25000", number))
        assert "line 2: a cell is not a number" in refusal(path)
    path.write_text(",".join(COLUMNS) + "\nshort,1\n")
    assert read_truth(path)[0].x_px is None  # cells that are absent are empty
    path.write_bytes(b"\xff\xfe\x00")
    assert "is no text" in refusal(path)
    path.write_text(",".join(COLUMNS) + "\ncut,1")
    assert "line 2: it ends after 2 of 16 cells, as if cut off" in refusal(path)


def test_an_unwritable_file_is_refused_in_one_line(tmp_path):
    with pytest.raises(UserError, match="cannot write"):
        write_truth(tmp_path / "no" / "t.csv", [SOME])


def table(*rows):
    """A truth table of dicts; what they lack is unknown."""
    lines = [",".join(COLUMNS), *(",".join(str(row.get(name, "")) for name in COLUMNS) for row in rows)]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    "rows, part",
    [
        ([], "names no frame"),
        ([{"id": 3}], "line 2: frame is missing"),
        ([{"frame": "a.pgm", "id": -1}], "line 2: -1 is no ID; without a marker it is left empty"),
        ([{"frame": "a.pgm", "id": 65535}], "line 2: 65535 is no ID"),
        ([{"frame": "a.pgm", "id": 3, "x_px": 5}] * 2, "line 3: the marker of line 2 once more"),
    ],
)
def test_what_no_truth_can_be_is_refused(tmp_path, rows, part):
    (tmp_path / "truth.csv").write_text(table(*rows))
    assert part in refusal(tmp_path / "truth.csv")


@pytest.mark.parametrize(
    "headings, is_told",
    [
        ((0.1, 3.2, 6.2), True),
        ((-3.1, 0.5), True),
        ((0.1, 1.5, 3.1), False),
        ((0.1, 3.2, 7), False),
        ((3,), False),
    ],
)
def test_headings_that_are_perhaps_radians_are_told(tmp_path, capsys, headings, is_told):
    rows = [{"frame": "%d.pgm" % k, "id": 3, "heading_deg": heading} for k, heading in enumerate(headings)]
    (tmp_path / "truth.csv").write_text(table(*rows))
    assert [one.heading_deg for one in read_truth(tmp_path)] == list(headings)
    assert ("are they radians?" in capsys.readouterr().err) == is_told
