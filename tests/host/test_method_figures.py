"""The pictures that explain the published method can be drawn, and show a marker read right."""

import cv2

from tools import method_figures


def test_figures_show_something(tmp_path):
    paths = method_figures.write(tmp_path / "new")
    assert sorted(path.name for path in paths) == ["method_bits.png", "method_votes.png"]
    for path in paths:
        picture = cv2.imread(str(path))
        assert picture.shape[0] > 250 and picture.shape[1] > 900
        assert picture.std() > 20


def test_the_marker_shown_is_read_right():
    _, _, found = method_figures.detection()
    truths = method_figures.render_frame(method_figures.PRESET, method_figures.SEED, method_figures.INDEX)[1]
    (truth,) = [truth for truth in truths if truth.id is not None]
    assert found.marker_id == truth.id
    assert abs((found.heading_cdeg / 100 - truth.heading_deg + 180) % 360 - 180) < 3
