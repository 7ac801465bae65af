"""The host's client against the camera's side of the commands, over a line that loses and damages."""

import random

import numpy as np
import pytest

from larics.device.commands import Commands
from larics.device.outbox import Outbox, Uptime
from larics.device.raw_frame import RawSender
from larics.settings import Settings
from larics.wire import messages as m
from larics.wire.codec import Decoder, Encoder
from larics_host.connection.client import Client, NoAnswer, Refused, Restarted
from larics_host.errors import UserError
from wire_values import at, message_values


class Camera:
    """A camera and its line; time passes by 1 ms at each read. `damage` is the chance that a piece that
    crosses the line loses a byte."""

    def __init__(self, damage=0.0, seed=1, baud=115200):
        self.random = random.Random(seed)
        self.damage = damage
        self.now_us = 0
        self.settings = Settings()
        self.saved = self.copies = 0
        self.raw = RawSender()
        self.uptime = Uptime()
        self.commands = Commands(self.settings, self.raw, self, 77, self.uptime, None)
        self.decoder = Decoder(self.commands.on_message)
        self.outbox = Outbox(self, Encoder(True), (self.commands, self.raw), baud, lambda new, old: new - old)
        self.line = bytearray()
        self.frame = 0
        self.silent = False

    # the camera's parts
    def free(self):
        return 1024

    def send(self, buffer, count):
        self.line += self.hurt(bytes(buffer[:count]))

    def info(self, values):
        values[at(m.INFO, "width")], values[at(m.INFO, "height")] = 40, 30
        values[at(m.INFO, "board")] = b"replay".ljust(16, b"\0")
        values[at(m.INFO, "unique_id")] = bytes(range(12))

    def settings_changed(self, name):
        pass

    def save(self):
        self.saved += 1

    def window(self):
        return 7, 5, 20, 12

    def raw_frame(self):
        self.copies += 1
        pixels = bytes(self.random.randrange(256) for _ in range(40 * 30))
        self.pixels = pixels
        return pixels, 40, 30, 5

    # the line
    def hurt(self, data):
        if self.random.random() < self.damage:
            place = self.random.randrange(len(data))
            return data[:place] + data[place + 1 :]
        return data

    def write(self, data):
        if not self.silent:
            data = self.hurt(data)
            self.decoder.feed(data, len(data))

    def read(self):
        self.now_us += 1000
        if self.now_us % 17000 == 0 and self.outbox.begin():
            values = message_values(m.MARKER, frame=self.frame, flags=m.MARKER_NONE, id=m.ID_NONE)
            self.outbox.add(m.MARKER, values)
            self.outbox.commit(self.now_us)
            self.frame += 1
        self.outbox.poll(self.now_us)
        data = bytes(self.line)
        self.line.clear()
        return data

    def client(self, **options):
        return Client(self, clock=lambda: self.now_us / 1e6, timeout_s=0.05, **options)


@pytest.mark.parametrize("damage", [0, 0.05, 0.2])
def test_every_command_over_a_line_that_loses_bytes(damage):
    camera = Camera(damage, seed=3)
    markers = []
    client = camera.client(retries=20, on_message=lambda number, _, values: markers.append(number))
    client.ping()
    info = client.info()
    assert (info.board, info.boot, info.unique_id) == ("replay", 77, bytes(range(12)))
    assert (info.width, info.height) == (40, 30)
    route = [k % 7 + 1 for k in range(50)]
    client.set("route", route)
    assert camera.settings.route == route == client.get("route")
    client.set("output", "nmea")
    assert client.get("output") == "nmea" and client.get("map") == []
    for count in range(1, 6):
        client.save()
        assert camera.saved == count
    raw = client.raw_frame()
    assert raw.pixels == camera.pixels and (raw.width, raw.height, raw.frame) == (40, 30, 5)
    assert camera.copies == 1
    raw = client.raw_frame(around_markers=True)
    assert raw.window == (7, 5, 20, 12) and (raw.width, raw.height) == (40, 30)
    window = np.frombuffer(camera.pixels, np.uint8).reshape(30, 40)[5:17, 7:27]
    assert (raw.array() == np.pad(window, ((5, 13), (7, 13)), mode="edge")).all()
    client.restart()
    assert camera.commands.restart_due
    assert markers.count(m.MARKER) > 10


def test_refusals_are_one_clear_line():
    camera = Camera()
    client = camera.client()
    with pytest.raises(UserError, match="rate_divider = 0 is not allowed: 1..255"):
        client.set("rate_divider", 0)
    with pytest.raises(UserError, match="no setting colour"):
        client.get("colour")
    with pytest.raises(Refused, match="refused SET_SETTING for radius_min_px: conflict") as caught:
        client.set("radius_min_px", 70)
    assert caught.value.reason == m.NACK_CONFLICT
    camera.raw_frame = lambda: None
    with pytest.raises(Refused, match="no frame"):
        client.raw_frame()


def test_silence_ends_with_an_error():
    camera = Camera()
    client = camera.client(retries=3)
    camera.silent = True
    with pytest.raises(NoAnswer, match="no answer to PING after 3 tries"):
        client.ping()
    assert camera.now_us < 1_000_000


def test_a_restart_of_the_camera_between_two_parts_is_told():
    camera = Camera()
    client = camera.client()
    client.info()
    carry_out = camera.commands.on_message
    parts = []

    def on_message(number, sequence, values):
        if number == m.SET_SETTING:
            parts.append(values)
            if len(parts) == 2:  # power lost and back: another boot, the settings as they were
                camera.commands = Commands(Settings(), camera.raw, camera, 78, camera.uptime, None)
                camera.outbox._answers = camera.commands
                camera.commands.announce()
                return
        carry_out(number, sequence, values)

    camera.decoder._on_message = on_message
    with pytest.raises(Restarted, match="restarted meanwhile: what was not saved is lost"):
        client.set("route", [k % 7 + 1 for k in range(50)])
    assert len(parts) == 2


def test_the_sequence_of_each_client_begins_anew():
    """Two programs, one after the other, that happen to draw the same tokens."""
    camera = Camera()
    for saved in (1, 2):
        client = camera.client()
        client._token = 40000
        client.ping()
        client.save()
        assert camera.saved == saved


def test_a_raw_transfer_that_stalls_ends_with_an_error():
    camera = Camera()
    client = camera.client()
    camera.raw.next = lambda: camera.raw._header_due and RawSender.next(camera.raw)
    with pytest.raises(NoAnswer, match="stopped at 0 of 1200 pixels"):
        client.raw_frame(stall_s=0.5)
