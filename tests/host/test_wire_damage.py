"""Mutated bytes through the Python decoder: nothing is accepted that was not sent."""

from larics import settings
from larics.device.outbox import Uptime
from larics.wire.encodings import measurement_encoder
from larics.wire.mavlink import MavlinkEncoder
from larics.wire.nmea import NmeaEncoder
from tools import fuzz_wire


def test_mutated_streams_in_python():
    figures = fuzz_wire.python_run(400_000, seed=21)
    assert figures["bytes"] >= 400_000 and figures["forged"] == 0
    assert figures["accepted"] == figures["messages"] > 5000
    assert min(figures[name] for name in ("crc", "cobs", "over_long", "empty", "length")) > 10


def test_the_setting_chooses_the_encoding():
    kinds = {"larics": type(None), "nmea": NmeaEncoder, "mavlink": MavlinkEncoder}
    for output, kind in kinds.items():
        assert type(measurement_encoder(settings.Settings({"output": output}), Uptime())) is kind
