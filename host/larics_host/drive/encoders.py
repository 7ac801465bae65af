"""What a vehicle sends to the camera: ODOMETRY of its wheels, by its own clock, over a slow line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from larics.wire import messages as m
from larics.wire.codec import Encoder
from larics_host.drive.vehicle import STEP_S, Vehicle
from larics_vehicle.odometer import Odometer


class Sender(Protocol):
    """Whoever makes bytes of what the wheels did: drive.c_controller.CController, or PythonSender."""

    def roll(self, left_um: int, right_um: int, track_mm: int, now_us: int) -> bool: ...

    def odometry(self, now_us: int) -> bytes: ...


class PythonSender:
    """larics_vehicle.odometer.Odometer behind the calls of CController."""

    def __init__(self) -> None:
        self._odometer = Odometer(epoch=1)
        self._encoder = Encoder()

    def roll(self, left_um: int, right_um: int, track_mm: int, now_us: int) -> bool:
        return bool(self._odometer.roll(left_um, right_um, track_mm, now_us & m.COUNT_MAX))

    def odometry(self, now_us: int) -> bytes:
        size = self._encoder.encode(m.ODOMETRY, self._odometer.message(now_us & m.COUNT_MAX))
        return bytes(self._encoder.buffer[:size])


@dataclass(frozen=True)
class Encoders:
    """seen       the encoders see what the wheels do, all but their bias; else only what the motors were told
    rate_hz       messages a second
    age_s         from reading the encoders to sending, at most; drawn anew for each message
    delay_s       on the way, beside the time on the line: a radio, another computer
    clock_ppm     how much faster than the camera's the vehicle's clock runs
    ahead_us      by how much it is ahead at the start
    """

    seen: bool = True
    rate_hz: float = 50.0
    age_s: float = 0.004
    delay_s: float = 0.0
    clock_ppm: float = 30.0
    ahead_us: int = 123_456_789


class Talk:
    """The vehicle's end of the line: `step` after each step of the vehicle, `until` before each frame."""

    def __init__(
        self, sender: Sender, encoders: Encoders, rng: np.random.Generator, baud: int, track_mm: float
    ) -> None:
        self._sender, self._encoders, self._rng = sender, encoders, rng
        self._baud, self._track_mm = baud, round(track_mm)
        self._rest_um = np.zeros(2)
        self._due_s = 0.0
        self._free_s = 0.0  # when the line has carried what was sent
        self._line: list[tuple[int, bytes]] = []

    def _vehicle_us(self, now_s: float) -> int:
        return round(now_s * (1e6 + self._encoders.clock_ppm)) + self._encoders.ahead_us & m.COUNT_MAX

    def step(self, vehicle: Vehicle, now_s: float) -> None:
        """The vehicle has made a step that ends now."""
        ways_mm = vehicle.rolled_mm if self._encoders.seen else vehicle.commanded_mm
        self._rest_um += ways_mm * 1000
        counted = np.round(self._rest_um)
        self._rest_um -= counted
        self._sender.roll(int(counted[0]), int(counted[1]), self._track_mm, self._vehicle_us(now_s))
        if now_s >= self._due_s - STEP_S / 2:
            self._due_s += 1 / self._encoders.rate_hz
            sent_s = now_s + self._rng.uniform(0, self._encoders.age_s)
            self.send(self._sender.odometry(self._vehicle_us(sent_s)), sent_s)

    def send(self, data: bytes, now_s: float) -> None:
        """Puts bytes on the line, behind those that are on it."""
        if data:
            self._free_s = max(self._free_s, now_s) + len(data) * 10 / self._baud
            self._line.append((round((self._free_s + self._encoders.delay_s) * 1e6), data))

    def until(self, now_s: float) -> list[tuple[int, bytes]]:
        """(time_us, bytes) of what has arrived by now and was not returned before."""
        now_us = round(now_s * 1e6)
        arrived = [piece for piece in self._line if piece[0] <= now_us]
        self._line = self._line[len(arrived) :]
        return arrived
