"""Commands from C, answered by the camera's own code; what gets lost on the line is asked for again."""

import random

import pytest

from c_parts import Parts
from larics.device.commands import Commands
from larics.device.outbox import Uptime
from larics.device.raw_frame import RawSender
from larics.settings import Settings, field
from larics.wire import messages as m
from larics.wire.codec import Decoder, Encoder
from wire_values import at

BOOT = 4711
IDLE, WAITING, DONE, REFUSED, TIMED_OUT = range(5)


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    return Parts(tmp_path_factory.mktemp("parts"))


class Actions:
    saves = 0

    def info(self, values):
        values[at(m.INFO, "board")], values[at(m.INFO, "unique_id")] = bytes(16), bytes(12)

    def settings_changed(self, name):
        pass

    def save(self):
        self.saves += 1

    def raw_frame(self):
        return None


class Camera:
    """The camera's side of the commands behind a line that loses what `loses` says."""

    def __init__(self, parts, seed=1, loses=lambda: False):
        self.parts, self.loses = parts, loses
        self.settings, self.actions = Settings(), Actions()
        self.commands = Commands(self.settings, RawSender(), self.actions, BOOT, Uptime(), None)
        self.encoder = Encoder()
        self.requests = []
        self.now_ms = 2**32 - 700  # the clock wraps on the way
        parts.init(seed)

    def _on_request(self, number, sequence, values):
        self.requests.append((number, list(values)))
        self.commands.on_message(number, sequence, values)

    def run(self, most_ms=60_000):
        """Turns of 10 ms until the command has ended; returns what the vehicle was told."""
        decoder = Decoder(self._on_request)
        for _ in range(most_ms // 10):
            request = self.parts.poll(self.now_ms % 2**32)
            if request and not self.loses():
                decoder.feed(request, len(request))
            number = self.commands.next()
            while number:
                size = self.encoder.encode(number, self.commands.values)
                if not self.loses():
                    self.parts.receive(self.encoder.buffer[:size])
                number = self.commands.next()
            if self.parts.told()[0] != WAITING:
                break
            self.now_ms += 10
        return self.parts.told()


def test_get_set_save_ping_info_and_restart(parts):
    camera = Camera(parts)
    assert parts.told()[0] == IDLE
    assert parts.begin(m.PING) and not parts.begin(m.PING)  # one at a time
    assert camera.run()[0] == DONE
    assert parts.begin(m.GET_SETTING, field("exposure_us").key, 1)
    state, _, _, count, _, numbers = camera.run()
    assert (state, count, numbers[0]) == (DONE, 1, camera.settings.exposure_us)
    assert parts.begin(m.SET_SETTING, field("exposure_us").key, values=[7777])
    assert camera.run()[0] == DONE and camera.settings.exposure_us == 7777
    assert parts.begin(m.SAVE_SETTINGS) and camera.run()[0] == DONE and camera.actions.saves == 1
    assert parts.begin(m.GET_INFO)
    assert camera.run()[:5] == (DONE, 0, 0, 0, BOOT)
    assert parts.begin(m.RESTART, BOOT + 1)
    assert camera.run()[:2] == (REFUSED, m.NACK_BOOT) and not camera.commands.restart_due
    assert parts.begin(m.RESTART, BOOT) and camera.run()[0] == DONE and camera.commands.restart_due


def test_lists_go_in_parts_and_come_back_in_order(parts):
    camera = Camera(parts)
    key = field("route").key
    for count in (0, 2, 8, 9, 20):
        wanted = [1 + k % 7 for k in range(count)]
        assert parts.begin(m.SET_SETTING, key, values=wanted)
        assert camera.run()[0] == DONE and list(camera.settings.route) == wanted
        assert parts.begin(m.GET_SETTING, key, 600)
        state, _, _, found, _, numbers = camera.run()
        assert (state, found, numbers[:found]) == (DONE, count, wanted)
    assert parts.begin(m.GET_SETTING, key, 3)  # room for three: the count tells that there are more
    assert camera.run()[3] == 20


def test_refusals_say_why(parts):
    camera = Camera(parts)
    key = field("exposure_us").key
    for begin, reason, detail in (
        ((m.GET_SETTING, 250, 1), m.NACK_UNKNOWN_KEY, 0),
        ((m.SET_SETTING, key, 0, [-5]), m.NACK_RANGE, key),
        ((m.SET_SETTING, key, 0, [2**31 - 1]), m.NACK_RANGE, key),  # not even the wire carries it
    ):
        assert parts.begin(*begin)
        assert camera.run()[:3] == (REFUSED, reason, detail)


def test_a_bad_line_loses_nothing_and_repeats_nothing(parts):
    draw = random.Random(3)
    key = field("route").key
    for seed in range(40):
        camera = Camera(parts, seed, loses=lambda: draw.random() < 0.25)
        first = draw.randint(1, 7)
        wanted = [first + k % 3 for k in range(draw.choice((2, 8, 17)))]
        outcome = []
        for begin in ((m.SET_SETTING, key, 0, wanted), (m.SAVE_SETTINGS,), (m.GET_SETTING, key, 600)):
            assert parts.begin(*begin)
            outcome.append(camera.run())
        assert all(told[0] in (DONE, TIMED_OUT) for told in outcome)
        if outcome[0][0] == DONE:
            assert list(camera.settings.route) == wanted
            if outcome[2][0] == DONE:
                assert outcome[2][5][: len(wanted)] == wanted
        assert camera.actions.saves <= 1  # carried out once, however often it was asked for
        tokens = [values[0] for _, values in camera.requests]
        assert len(set(tokens)) <= len(tokens)


def test_time_out_and_cancel(parts):
    camera = Camera(parts, loses=lambda: True)
    assert parts.begin(m.PING)
    began = camera.now_ms
    assert camera.run()[0] == TIMED_OUT and camera.now_ms - began == 2000  # four tries, half a second each
    assert parts.begin(m.PING)
    parts.cancel()
    assert parts.told()[0] == TIMED_OUT and parts.poll(0) == b""


def test_the_first_token_is_random_and_a_repetition_keeps_it(parts):
    firsts = set()
    for seed in range(200):
        camera = Camera(parts, seed + 1)
        parts.begin(m.PING)
        camera.run()
        parts.begin(m.PING)
        camera.run()
        (_, first), (_, second) = camera.requests
        assert second[0] == (first[0] + 1) % 65536
        firsts.add(first[0])
    assert len(firsts) > 190
    camera = Camera(parts, loses=iter([False, True] + [False] * 50).__next__)  # the first answer is lost
    parts.begin(m.SAVE_SETTINGS)
    assert camera.run()[0] == DONE and camera.actions.saves == 1
    assert len(camera.requests) == 2 and camera.requests[0] == camera.requests[1]
