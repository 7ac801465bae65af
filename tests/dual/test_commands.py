"""Commands: answered with their token, carried out once, refused with a reason; raw frames in chunks."""

from binascii import crc32

from larics.device.commands import Commands
from larics.device.outbox import Uptime
from larics.device.raw_frame import RawSender
from larics.settings import FIELDS, Settings, field
from larics.wire import codec as p
from larics.wire import messages as m
from wire_values import at, message_values, named

BOOT = 4711


class Actions:
    def __init__(self):
        self.changed = []
        self.saves = 0
        self.broken_flash = False
        self.frame = self.around = None

    def info(self, values):
        values[at(m.INFO, "width")], values[at(m.INFO, "height")] = 360, 296
        values[at(m.INFO, "board")], values[at(m.INFO, "unique_id")] = b"replay" + bytes(10), bytes(12)

    def settings_changed(self, name):
        self.changed.append(name)

    def save(self):
        if self.broken_flash:
            raise OSError(28)
        self.saves += 1

    def raw_frame(self):
        return self.frame

    def window(self):
        return self.around


class Odometry:
    def __init__(self):
        self.taken = 0

    def take(self, values):
        self.taken += 1


class Bench:
    def __init__(self):
        self.actions = Actions()
        self.settings = Settings()
        self.raw = RawSender()
        self.uptime = Uptime()
        self.odometry = Odometry()
        self.commands = Commands(self.settings, self.raw, self.actions, BOOT, self.uptime, self.odometry)
        self.sequence = 65530

    def ask(self, number, *values):
        """Sends a command; returns every message that comes back as (type, values)."""
        assert len(values) == len(p.fields(number))
        self.commands.on_message(number, self.sequence, list(values))
        self.sequence = (self.sequence + 1) & 0xFFFF
        return self.answers()

    def answers(self):
        found = []
        number = self.commands.next()
        while number:
            p.Encoder().encode(number, self.commands.values)  # every answer is within its ranges
            found.append((number, list(self.commands.values)[: len(p.fields(number))]))
            number = self.commands.next()
        assert not self.commands.busy()
        return found

    def set(self, token, name, numbers, first=0, count=None):
        key = field(name).key
        count = len(numbers) if count is None else count
        values = message_values(m.SET_SETTING, token=token, key=key, first=first, count=count)
        place = at(m.SET_SETTING, "value0")
        part = numbers[first : first + m.SETTING_VALUES]
        values[place : place + len(part)] = part
        return self.ask(m.SET_SETTING, *values)


def ack(token, command):
    return (m.ACK, message_values(m.ACK, token=token, command=command))


def nack(token, command, reason, detail=0):
    return (m.NACK, message_values(m.NACK, token=token, command=command, reason=reason, detail=detail))


def test_ping_and_info():
    bench = Bench()
    assert bench.ask(m.PING, 7) == [ack(7, m.PING)]
    (kind, values), answer = bench.ask(m.GET_INFO, 8)
    info = named(m.INFO, values)
    assert kind == m.INFO and (info["token"], info["boot"]) == (8, BOOT)
    assert (info["width"], info["height"]) == (360, 296)
    assert answer == ack(8, m.GET_INFO)
    bench.commands.announce()
    info = named(m.INFO, bench.answers()[0][1])
    assert (info["token"], info["boot"]) == (0, BOOT)


def test_measurements_are_no_commands():
    bench = Bench()
    bench.commands.on_message(m.ACK, 0, message_values(m.ACK))
    assert bench.answers() == []


def test_get_every_setting():
    bench = Bench()
    bench.settings.update({"route": [64 * k + 1 for k in range(20)]})
    bench.settings.update({"map": [[64 * k + 1, 1000 * k, -1000 * k, k, 0, 0] for k in range(63)]})
    for token, entry in enumerate(FIELDS):
        found = bench.ask(m.GET_SETTING, token, entry.key)
        assert found.pop() == ack(token, m.GET_SETTING)
        numbers = []
        for kind, values in found:
            part = named(kind, values)
            assert kind == m.SETTING and (part["token"], part["key"]) == (token, entry.key)
            assert part["first"] == len(numbers)
            numbers.extend(values[at(m.SETTING, "value0") :])
        length = named(m.SETTING, found[0][1])["count"]
        assert len(numbers) - length < 8 or length == 0
        assert entry.value(numbers[:length]) == getattr(bench.settings, entry.name)
    assert bench.ask(m.GET_SETTING, 9, 250) == [nack(9, m.GET_SETTING, m.NACK_UNKNOWN_KEY)]


def test_set_and_its_reasons():
    bench = Bench()
    key = field("rate_divider").key
    assert bench.set(1, "rate_divider", [3]) == [ack(1, m.SET_SETTING)]
    assert bench.settings.rate_divider == 3 and bench.actions.changed == ["rate_divider"]
    assert bench.set(2, "rate_divider", [0]) == [nack(2, m.SET_SETTING, m.NACK_RANGE, key)]
    assert bench.set(3, "rate_divider", [1, 2]) == [nack(3, m.SET_SETTING, m.NACK_LENGTH, key)]
    assert bench.set(4, "rate_divider", []) == [nack(4, m.SET_SETTING, m.NACK_LENGTH, key)]
    assert bench.set(5, "baud", [99])[0][1][at(m.NACK, "reason")] == m.NACK_RANGE
    assert bench.set(6, "radius_min_px", [61])[0][1][at(m.NACK, "reason")] == m.NACK_CONFLICT
    before = bench.settings.as_dict()
    for name, number in (("radius_max_px", 10), ("width", 80), ("line_mm10", 20), ("focal_q8", 5120)):
        bench.settings.update({"radius_min_px": 45} if name == "width" else {"radius_min_px": 10})
        answer = bench.set(20 + field(name).key, name, [number])
        assert answer == [nack(20 + field(name).key, m.SET_SETTING, m.NACK_CONFLICT, field(name).key)]
    bench.settings.update({"radius_min_px": 10})
    assert bench.settings.as_dict() == before
    assert bench.set(7, "map", [1, 2, 3])[0][1][at(m.NACK, "reason")] == m.NACK_LENGTH
    unknown = bench.ask(m.SET_SETTING, *message_values(m.SET_SETTING, token=8, key=250, count=1))
    assert unknown == [nack(8, m.SET_SETTING, m.NACK_UNKNOWN_KEY, 250)]
    assert bench.settings.rate_divider == 3 and bench.actions.changed == ["rate_divider"]
    assert bench.set(9, "output", [1]) == [ack(9, m.SET_SETTING)] and bench.settings.output == "nmea"


def test_a_list_takes_effect_with_its_last_part():
    bench = Bench()
    route = list(range(1, 21))
    assert bench.set(1, "route", route, 0) == [ack(1, m.SET_SETTING)]
    assert bench.set(2, "route", route, 16) == [nack(2, m.SET_SETTING, m.NACK_LIST_ORDER, field("route").key)]
    assert bench.set(3, "route", route, 8) == [ack(3, m.SET_SETTING)]
    assert bench.set(3, "route", route, 8) == [ack(3, m.SET_SETTING)]  # a retry does not count twice
    assert bench.settings.route == []
    assert bench.set(4, "route", route, 16) == [ack(4, m.SET_SETTING)]
    assert bench.settings.route == route
    assert bench.set(5, "route", []) == [ack(5, m.SET_SETTING)]
    assert bench.settings.route == []


def test_retries_are_carried_out_once():
    bench = Bench()
    for _ in range(3):
        assert bench.ask(m.SAVE_SETTINGS, 1) == [ack(1, m.SAVE_SETTINGS)]
    assert bench.actions.saves == 1
    bench.actions.broken_flash = True
    for _ in range(2):
        assert bench.ask(m.SAVE_SETTINGS, 2) == [nack(2, m.SAVE_SETTINGS, m.NACK_STORAGE)]
    assert bench.set(1, "rate_divider", [3]) == [nack(1, m.SET_SETTING, m.NACK_TOKEN)]
    assert bench.set(3, "rate_divider", [3]) == [ack(3, m.SET_SETTING)]
    assert bench.set(3, "rate_divider", [4]) == [nack(3, m.SET_SETTING, m.NACK_TOKEN)]
    assert bench.settings.rate_divider == 3
    for token in range(10, 30):  # what is remembered does not grow
        bench.set(token, "rate_divider", [token])
    assert bench.set(22, "rate_divider", [22]) == [ack(22, m.SET_SETTING)]
    assert bench.settings.rate_divider == 29  # the last eight are
    assert bench.set(21, "rate_divider", [21]) == [ack(21, m.SET_SETTING)]
    assert bench.settings.rate_divider == 21


def test_a_requester_that_starts_anew_is_not_answered_from_memory():
    bench = Bench()
    bench.sequence = 0
    for _ in range(2):
        assert bench.set(1, "rate_divider", [3]) == [ack(1, m.SET_SETTING)]
    assert bench.set(2, "rate_divider", [5]) == [ack(2, m.SET_SETTING)]
    assert bench.ask(m.SAVE_SETTINGS, 3) == [ack(3, m.SAVE_SETTINGS)]
    route = list(range(1, 21))
    bench.set(4, "route", route, 0)
    bench.sequence = 0  # it has restarted, and draws the same tokens
    assert bench.set(1, "rate_divider", [3]) == [ack(1, m.SET_SETTING)]
    assert bench.settings.rate_divider == 3
    assert bench.ask(m.SAVE_SETTINGS, 3) == [ack(3, m.SAVE_SETTINGS)] and bench.actions.saves == 2
    assert bench.set(4, "rate_divider", [7]) == [ack(4, m.SET_SETTING)]  # no NACK_TOKEN either
    assert bench.set(5, "route", route, 8)[0][1] == nack(5, m.SET_SETTING, m.NACK_LIST_ORDER, 60)[1]


def test_odometry_numbers_the_same_requester():
    bench = Bench()
    assert bench.ask(m.SAVE_SETTINGS, 3) == [ack(3, m.SAVE_SETTINGS)]
    for _ in range(70000):
        bench.commands.on_message(m.ODOMETRY, bench.sequence, message_values(m.ODOMETRY))
        bench.sequence = (bench.sequence + 1) & 0xFFFF
    assert bench.ask(m.SAVE_SETTINGS, 3) == [ack(3, m.SAVE_SETTINGS)] and bench.actions.saves == 1
    assert bench.odometry.taken == 70000 and bench.commands.unanswered == 0


def test_an_answer_is_remembered_for_half_a_minute():
    bench = Bench()
    for s, saves in ((0, 1), (30, 1), (31, 2), (61, 2), (62, 3)):
        bench.uptime.s = s
        assert bench.ask(m.SAVE_SETTINGS, 1) == [ack(1, m.SAVE_SETTINGS)]
        assert bench.actions.saves == saves, s


def test_restart_needs_the_current_boot_number():
    bench = Bench()
    assert bench.ask(m.RESTART, 1, BOOT - 1) == [nack(1, m.RESTART, m.NACK_BOOT)]
    assert not bench.commands.restart_due
    assert bench.ask(m.RESTART, 2, BOOT) == [ack(2, m.RESTART)]
    assert bench.commands.restart_due


def test_a_flood_of_requests_is_bounded():
    bench = Bench()
    for token in range(100):
        bench.commands.on_message(m.PING, 0, message_values(m.PING, token=token))
    assert len(bench.answers()) == 8 and bench.commands.unanswered == 92


def _chunks(raw):
    found = []
    number = raw.next()
    while number:
        values = [bytes(v) if isinstance(v, bytearray) else v for v in raw.values]
        p.Encoder().encode(number, values)
        found.append((number, values))
        number = raw.next()
    return found


def noise(k):
    """0..255, another for each k."""
    return k * k * 403 % 65521 >> 7 & 255


def _named_chunks(raw):
    return [named(number, values) for number, values in _chunks(raw)]


def test_a_raw_frame_in_chunks_whose_pixels_can_be_asked_for_again():
    bench = Bench()
    assert bench.ask(m.GET_RAW, 1, 0) == [nack(1, m.GET_RAW, m.NACK_NO_FRAME)]
    width, height = 30, 15
    pixels = bytearray([noise(k) for k in range(width * height)])  # cannot be packed
    bench.actions.frame = (pixels, width, height, 99)
    assert bench.ask(m.GET_RAW, 2, 0) == [ack(2, m.GET_RAW)]
    head, *chunks = _named_chunks(bench.raw)
    assert (head["token"], head["frame"], head["crc_low"]) == (2, 99, crc32(pixels) & 0xFFFF)
    assert (head["width"], head["height"], head["columns"], head["rows"]) == (width, height, width, height)
    # strips of 16 and 14 columns, each begun with a chunk of its own
    assert [one["first"] for one in chunks] == [0, 64, 128, 192, 240, 304, 368, 432]
    assert [one["count"] for one in chunks] == [64, 64, 64, 48, 64, 64, 64, 18]
    assert [one["coding"] for one in chunks] == [m.RAW_PLAIN] * 8
    data = b"".join([one["data"][: one["count"]] for one in chunks])
    rows = [bytes(pixels[30 * row : 30 * row + 30]) for row in range(height)]
    assert data == b"".join([row[:16] for row in rows] + [row[16:] for row in rows])
    assert chunks[-1]["data"][18:] == bytes(46)
    assert bench.ask(m.GET_RAW_AGAIN, 3, 2, 304, 146) == [ack(3, m.GET_RAW_AGAIN)]
    assert bench.ask(m.GET_RAW_AGAIN, 3, 2, 304, 146) == [ack(3, m.GET_RAW_AGAIN)]
    assert _named_chunks(bench.raw) == chunks[5:]
    assert bench.ask(m.GET_RAW_AGAIN, 4, 2, 305, 146) == [nack(4, m.GET_RAW_AGAIN, m.NACK_PIXELS)]
    assert bench.ask(m.GET_RAW_AGAIN, 5, 1, 0, 1) == [nack(5, m.GET_RAW_AGAIN, m.NACK_TRANSFER)]
    assert bench.ask(m.GET_RAW, 2, 0) == [ack(2, m.GET_RAW)]  # the answer was lost: header again, no chunks
    assert _named_chunks(bench.raw) == [head]
    for token in range(10, 17):
        assert bench.ask(m.GET_RAW_AGAIN, token, 2, 0, 1) == [ack(token, m.GET_RAW_AGAIN)]
    assert bench.ask(m.GET_RAW_AGAIN, 17, 2, 0, 1) == [nack(17, m.GET_RAW_AGAIN, m.NACK_BUSY)]


def test_the_packed_chunks_of_a_window_are_the_same_bytes_on_every_interpreter():
    bench = Bench()
    width, height = 60, 50
    pixels = bytearray([noise(k) % (k // 500 + 1) + 2 * (k % 60) for k in range(width * height)])
    bench.actions.frame, bench.actions.around = (pixels, width, height, 99), (7, 5, 41, 40)
    assert bench.ask(m.GET_RAW, 2, m.RAW_MARKERS) == [ack(2, m.GET_RAW)]
    head, *chunks = _named_chunks(bench.raw)
    assert [head[name] for name in ("left", "top", "columns", "rows")] == [7, 5, 41, 40]
    assert sum([one["count"] for one in chunks]) == 41 * 40 and len(chunks) == 14
    codings, data = bytes([one["coding"] for one in chunks]), b"".join([one["data"] for one in chunks])
    assert crc32(codings + data) == 0x3333FFD
    bench.actions.around = None  # nothing was found in that frame
    assert bench.ask(m.GET_RAW, 3, m.RAW_MARKERS) == [ack(3, m.GET_RAW)]
    head, *_ = _named_chunks(bench.raw)
    assert [head[name] for name in ("left", "top", "columns", "rows")] == [0, 0, width, height]
