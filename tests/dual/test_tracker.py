"""Following one marker never costs sight of another."""

from larics.detect.tracker import Tracker
from larics.device.factory import make_detector
from larics.marker.detection import FLAG_BLUR_MODEL, FLAG_BORDER, FLAG_TRACKED, FLAG_UNCONFIRMED
from larics.settings import Settings
from marker_drawing import draw

WIDTH, HEIGHT = 240, 120


class Finder:
    """In place of a detector: finds what it is told and notes how it was asked."""

    def __init__(self):
        self.found = []
        self.calls = ""

    def detect(self, frame):
        self.calls += "s"
        return self.found

    def track(self, frame):
        self.calls += "t"
        return self.found[:1]


class Seen:
    def __init__(self, marker_id=3, flags=0):
        self.marker_id = marker_id
        self.flags = flags


def calls(found, frames=20):
    finder = Finder()
    finder.found = found
    tracker = Tracker(finder)
    for _ in range(frames):
        tracker.detect(None)
    return finder.calls


def test_a_single_marker_is_followed_and_the_frame_searched_every_eighth_time():
    assert calls([Seen()]) == "stttttttstttttttsttt"


def test_what_is_not_safe_to_follow_is_searched_for():
    for found in (
        [],
        [Seen(), Seen(4)],
        [Seen(-1)],
        [Seen(flags=FLAG_BORDER)],
        [Seen(flags=FLAG_BLUR_MODEL)],
    ):
        assert calls(found) == "s" * 20


def settings(**values):
    usual = {"width": WIDTH, "height": HEIGHT, "radius_min_px": 22, "radius_max_px": 30}
    return Settings(dict(usual, **values))


def frame(marker_ids, shift=0):
    """Markers side by side, the first at the left."""
    picture = draw(WIDTH, HEIGHT, marker_ids[0], 960 + shift, 960, 400, 0)
    if len(marker_ids) > 1:
        other = draw(WIDTH, HEIGHT, marker_ids[1], 2880, 960, 400, 0)
        for row in range(HEIGHT):
            picture[row * WIDTH + 120 : (row + 1) * WIDTH] = other[row * WIDTH + 120 : (row + 1) * WIDTH]
    return picture


def ids(found):
    return sorted([one.marker_id for one in found])


def test_a_second_marker_is_found_while_the_first_is_followed():
    finder = make_detector(settings())
    alone, both = frame([3]), frame([3, 5])
    assert ids(finder.detect(alone)) == [3]
    found = finder.detect(alone)
    assert ids(found) == [3] and found[0].flags & FLAG_TRACKED
    waited = 0
    while ids(finder.detect(both)) != [3, 5]:
        waited += 1
    assert 0 < waited < 8
    for _ in range(10):
        assert ids(finder.detect(both)) == [3, 5]  # none of the two is left out from now on


def test_without_tracking_every_frame_is_searched():
    finder = make_detector(settings(tracking=False))
    picture = frame([3])
    for _ in range(3):
        assert not finder.detect(picture)[0].flags & FLAG_TRACKED


def test_the_settings_reach_the_detector():
    picture = frame([3])
    assert ids(make_detector(settings(allowed_ids=[3, 5])).detect(picture)) == [3]
    assert ids(make_detector(settings(allowed_ids=[5])).detect(picture)) == [-1]
    # a mirrored sensor's 6 is read as a 3
    assert ids(make_detector(settings(allowed_ids=[6], mirrored=True)).detect(picture)) == [3]
    assert ids(make_detector(settings(allowed_ids=[3], mirrored=True)).detect(picture)) == [-1]
    finder = make_detector(settings(confirm_needed=3, confirm_frames=4))
    flags = [finder.detect(picture)[0].flags & FLAG_UNCONFIRMED for _ in range(4)]
    assert flags == [FLAG_UNCONFIRMED, FLAG_UNCONFIRMED, 0, 0]
    zero = frame([4])
    for row in range(46, 75):
        for column in range(46, 75):
            zero[row * WIDTH + column] = 195  # its coding line is gone
    assert ids(make_detector(settings()).detect(zero)) in ([], [-1])
    assert ids(make_detector(settings(allow_id0=True)).detect(zero)) == [0]
    assert ids(make_detector(settings(line_mm10=200)).detect(picture)) == [3]


def test_frames_of_another_size_than_the_settings():
    finder = make_detector(settings(width=320, height=240), (WIDTH, HEIGHT))
    assert ids(finder.detect(frame([5]))) == [5]
