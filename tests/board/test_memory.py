"""A setting that does not fit in memory is refused, and the detection goes on: on the interpreter's heap."""

import gc
import sys
from binascii import crc32

from board_parts import Clock, Uart, make_app, marker

import actions
import heap
import parts
from larics.arith import fixed
from larics.device.raw_frame import RawSender
from larics.settings import field
from larics.wire import codec as protocol
from larics.wire import messages as m
from wire_values import at, message_values

PICTURES = [marker(5, 80, 60, 20), marker(5, 81, 60, 20)]
USUAL = {"method": "larics", "radius_min_px": 28, "radius_max_px": 30}


def leave(free_bytes):
    """Fills the heap but for one piece of so many bytes, and what is smaller than 1 KiB."""
    gc.collect()
    room = bytearray(free_bytes)
    ballast = []
    size = 65536
    while size >= 1024:
        try:
            ballast.append(bytearray(size))
        except MemoryError:
            size >>= 1
    room = None
    gc.collect()
    return ballast, room


class Program:
    def __init__(self, settings=None, **options):
        self.clock, self.uart = Clock(step_us=50), Uart(collect=True)
        values = dict(USUAL, **(settings or {}))
        self.app = make_app(PICTURES, self.uart, values, clock=self.clock, **options)
        self.token = 0

    def run(self, ms):
        end_us = self.clock.now_us + 1000 * ms
        while self.clock.now_us < end_us:
            self.app.loop.step()
            self.clock.now_us += 10000

    def set(self, name, value):
        """(ACK or NACK, reason) of a SET_SETTING."""
        self.token += 1
        entry = field(name)
        numbers = entry.numbers(value)
        given = {"value%d" % k: number for k, number in enumerate(numbers)}
        values = message_values(
            m.SET_SETTING, token=self.token, key=entry.key, first=0, count=len(numbers), **given
        )
        encoder = protocol.Encoder()
        self.uart.incoming += bytes(encoder.buffer[: encoder.encode(m.SET_SETTING, values)])
        self.run(300)
        for kind, reply in self.uart.messages():
            if kind in (m.ACK, m.NACK) and reply[0] == self.token:
                return kind, reply[at(m.NACK, "reason")] if kind == m.NACK else 0

    def frames(self):
        return self.app.status.frames

    def collected(self):
        """What was sent is told and thrown away, since it is no part of the program."""
        found = self.uart.messages()
        self.uart.sent = bytearray()
        return found


def test_a_setting_that_does_not_fit_is_refused_and_the_detection_goes_on():
    program = Program()
    program.run(300)
    detector = program.app.parts.sensor.detector
    program.collected()
    ballast, _ = leave(24000)  # the test's own lines are kept there, too
    assert program.set("radius_min_px", 6) == (m.NACK, m.NACK_MEMORY)
    program.collected()
    app = program.app
    assert app.settings.radius_min_px == 28 and app.parts.sensor.detector is not None
    assert app.parts.sensor.detector is detector and not app.faults.active  # there was room for a try
    before = program.frames()
    program.run(500)
    assert program.frames() > before + 20
    program.collected()
    assert program.set("rate_divider", 2) == (m.ACK, 0)
    del ballast[:]
    gc.collect()
    assert program.set("radius_min_px", 6) == (m.ACK, 0) and app.settings.radius_min_px == 6
    assert not app.faults.active


def test_without_memory_for_the_detector_before_it_goes_on_without_second_opinion():
    program = Program()
    program.run(300)
    app = program.app
    real = app.parts.sensor.rebuild
    heap.small = True  # as on a small heap: the one before is given up first

    def tight(wanted, settings=None):
        """As if the heap had been cut up: of detectors, only one without second opinion fits."""
        if wanted & 1 and app.settings.second_opinion:
            raise MemoryError
        real(wanted, settings)

    app.parts.sensor.rebuild = tight
    assert program.set("margin_min", 20) == (m.NACK, m.NACK_MEMORY)
    assert app.faults.active == 1 << m.FAULT_MEMORY and app.settings.second_opinion
    assert app.settings.margin_min == 16
    before = program.frames()
    program.run(500)
    assert program.frames() > before + 20
    app.parts.sensor.rebuild = real
    heap.small = False
    assert program.set("margin_min", 20) == (m.ACK, 0)  # there is memory again: the fault is over
    assert not app.faults.active and app.settings.margin_min == 20


def test_the_pose_in_a_map_comes_before_the_second_opinion():
    made = Program().app.parts
    free, reader = heap.free_bytes, sys.modules.pop("larics.blurred.reader")
    heap.small = True
    try:
        made._settings.map = [[3, 0, 0, 0, 0, 0, 0, 0]]
        for room, is_loaded in ((parts._WITH_MAP - 1, False), (parts._WITH_MAP, True)):
            heap.free_bytes = lambda more=room: parts._WITH_SECOND_OPINION + more
            try:
                made._load_code()
                assert is_loaded
            except MemoryError:
                assert not is_loaded
    finally:
        heap.small, heap.free_bytes, sys.modules["larics.blurred.reader"] = False, free, reader


def test_without_memory_for_fine_grids_it_goes_on_without_small_rings():
    program = Program({"radius_min_px": 10})
    program.run(300)
    app = program.app
    real = app.parts.sensor.rebuild
    cells = len(fixed._kept["cells"])

    def tight(wanted, settings=None):
        if wanted & 1 and app.settings.radius_min_px < 15:
            raise MemoryError
        real(wanted, settings)

    app.parts.sensor.rebuild = tight
    heap.small = True
    assert program.set("margin_min", 20) == (m.NACK, m.NACK_MEMORY)
    heap.small = False
    assert app.faults.active == 1 << m.FAULT_MEMORY
    assert app.settings.second_opinion and app.settings.radius_min_px == 10
    detector = app.parts.sensor.detector._detector
    assert detector.blur_reader is None and detector._scales[0].radius_min_q8 == 15 << 8
    assert len(fixed._kept["cells"]) < cells
    before = program.frames()
    program.run(500)
    assert program.frames() > before + 20
    app.parts.sensor.rebuild = real
    assert program.set("margin_min", 20) == (m.ACK, 0) and not app.faults.active
    assert app.parts.sensor.detector._detector._scales[0].radius_min_q8 == 10 << 8


def test_settings_are_kept_where_a_detector_leaves_no_memory_for_their_text():
    class Tight:
        """Of the settings' file only a part fits beside a detector; nothing does when `full`."""

        full = False
        saved = 0

        def save(self, settings):
            if self.full or program.app.parts.sensor.detector is not None:
                raise MemoryError
            self.saved += 1
            return True

    keeper = Tight()
    program = Program(keeper=keeper)
    program.run(300)
    app = program.app
    for keeper.full in (False, True):
        program.collected()
        encoder = protocol.Encoder()
        size = encoder.encode(m.SAVE_SETTINGS, message_values(m.SAVE_SETTINGS, token=8 + keeper.full))
        program.uart.incoming += bytes(encoder.buffer[:size])
        before = program.frames()
        program.run(500)
        kinds = [kind for kind, _ in program.collected()]
        assert (m.NACK if keeper.full else m.ACK) in kinds
        assert app.parts.sensor.detector is not None and program.frames() > before + 20
        assert not app.faults.active and keeper.saved == 1


def test_when_the_heap_is_too_cut_up_for_any_detector_the_board_restarts():
    program = Program()
    program.run(300)
    app = program.app

    def none(wanted, settings=None):
        raise MemoryError

    app.parts.sensor.rebuild = none
    heap.small = True
    assert program.set("margin_min", 20) == (m.NACK, m.NACK_MEMORY)
    heap.small = False
    assert app.commands.restart_due and app.faults.active == 1 << m.FAULT_MEMORY


def test_a_map_that_does_not_fit_leaves_the_one_before():
    place = [[5, 0, 0, 0, 0, 0]]
    program = Program({"focal_q8": 200 * 256, "map": place})
    program.run(300)
    app = program.app
    navigator = app.parts.sensor.navigator
    real = app.parts.sensor.rebuild

    def tight(parts, settings=None):
        raise MemoryError

    app.parts.sensor.rebuild = tight
    app.settings.map = [[5, 10, 0, 0, 0, 0]]
    assert app.actions.settings_changed("map") is False
    app.settings.map = place
    app.actions.settings_restored("map")
    app.parts.sensor.rebuild = real
    assert app.parts.sensor.navigator is navigator and app.parts.sensor.detector is not None
    assert app.faults.last == m.FAULT_MEMORY and not app.faults.active


def test_without_memory_for_a_copy_the_frame_itself_is_sent_and_no_other_comes_meanwhile():
    program = Program()
    program.run(300)
    app = program.app

    def none(size):
        raise MemoryError

    actions.bytearray = none
    try:
        encoder = protocol.Encoder()
        program.collected()
        program.uart.incoming += bytes(
            encoder.buffer[: encoder.encode(m.GET_RAW, message_values(m.GET_RAW, token=9))]
        )
        program.run(200)
        frames = program.frames()
        while app.commands._raw.busy():
            program.run(50)
        assert program.frames() == frames and not app.faults.total
    finally:
        del actions.bytearray
    crcs, sent, expected = [], [], []

    def take(number, sequence, values):
        if number == m.RAW_HEADER:
            crcs.append((values[at(number, "crc_low")], values[at(number, "crc_high")]))
        elif number == m.RAW_CHUNK:
            sent.append(bytes(values[at(number, "data")]))

    protocol.Decoder(take).feed(program.uart.sent, len(program.uart.sent))
    (crc,) = crcs
    for picture in PICTURES:
        if crc == (crc32(picture) & 0xFFFF, crc32(picture) >> 16):
            sender = RawSender()
            sender.start(9, picture, 160, 120, 0)
            sender.next()  # the header
            while sender.next():
                expected.append(bytes(sender.values[at(m.RAW_CHUNK, "data")]))
    assert sent == expected and len(sent) > 20
    program.run(3000)
    assert program.frames() > frames + 10 and app.commands._raw.token == -1


def test_only_a_small_heap_keeps_room_for_the_detector_while_loading():
    assert sys.implementation.name == "micropython"
    wanted = heap._TWO_DETECTORS, heap._ROOM
    try:
        heap._TWO_DETECTORS, heap._ROOM = 1 << 28, 1 << 28  # as where there is less than that
        assert heap._is_small()
        assert 1 << 14 < len(heap._piece()[0]) < 1 << 28
        heap._TWO_DETECTORS, heap._ROOM = 1000, 1000
        assert not heap._is_small()
        assert [len(piece) for piece in heap._piece()] == [1000]
    finally:
        heap._TWO_DETECTORS, heap._ROOM = wanted
    before = heap.small
    try:
        for heap.small, threshold in ((False, 65536), (True, -1)):
            gc.threshold(65536)
            heap.loaded()
            assert gc.threshold() == threshold
    finally:
        gc.threshold(-1)
        heap.small = before


def test_what_is_free_includes_the_room():
    heap.room.append(bytearray(20000))
    try:
        assert abs(heap.free_bytes() - gc.mem_free() - 20000) < 2000
    finally:
        heap.room.clear()
