"""A differential-drive vehicle: what its wheels make of the commanded speed and turn rate."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from larics_host.render.camera import Motion, Pose

STEP_S = 0.005


@dataclass(frozen=True)
class Drivetrain:
    """track_mm        between the wheels
    delay_s           from a command to its first effect
    lag_s             time constant of the motors
    bias, noise       standard deviation of each wheel's share of speed gained or lost: for the whole drive,
                      and fluctuating with the time constant noise_s
    """

    track_mm: float = 300.0
    delay_s: float = 0.06
    lag_s: float = 0.08
    bias: float = 0.003
    noise: float = 0.02
    noise_s: float = 0.3


class Vehicle:
    """Moves in steps of STEP_S. `pose`, `motion`: the truth; `way_mm`: driven so far.

    After each step, `rolled_mm` and `commanded_mm`: the ways of the left and right wheel by encoders, which
    see all but the bias, and by what the motors were told, which sees neither that nor the noise."""

    def __init__(self, pose: Pose, rng: np.random.Generator, drivetrain: Drivetrain | None = None) -> None:
        self.drivetrain = drivetrain or Drivetrain()
        self.pose = pose
        self.motion = Motion()
        self.way_mm = 0.0
        self.rolled_mm = self.commanded_mm = np.zeros(2)
        self._rng = rng
        self._bias = rng.normal(0.0, self.drivetrain.bias, 2)
        self._noise = np.zeros(2)
        self._wheels = np.zeros(2)  # mm/s, left and right
        waiting = max(1, round(self.drivetrain.delay_s / STEP_S))
        self._commands = deque([(0.0, 0.0)] * waiting, maxlen=waiting)

    def step(self, speed_mm_s: float, turn_deg_s: float) -> None:
        """STEP_S with this command."""
        train = self.drivetrain
        speed, turn = self._commands[0]
        self._commands.append((speed_mm_s, turn_deg_s))
        half = math.radians(turn) * train.track_mm / 2
        wanted = np.array([speed - half, speed + half])
        self._wheels += (wanted - self._wheels) * min(1.0, STEP_S / train.lag_s)
        keep = math.exp(-STEP_S / train.noise_s)
        fresh = self._rng.normal(0.0, train.noise * math.sqrt(1 - keep * keep), 2)
        self._noise = keep * self._noise + fresh
        left, right = self._wheels * (1 + self._bias + self._noise)
        self.rolled_mm, self.commanded_mm = self._wheels * (1 + self._noise) * STEP_S, self._wheels * STEP_S
        self.motion = Motion((left + right) / 2, 0.0, math.degrees((right - left) / train.track_mm))
        self.pose = self.motion.pose_after(self.pose, STEP_S)
        self.way_mm += abs(left + right) / 2 * STEP_S

    def push(self, forward_mm: float, left_mm: float, turn_deg: float) -> None:
        """Puts the vehicle elsewhere, as a person does."""
        angle = math.radians(self.pose.heading_deg)
        self.pose = Pose(
            self.pose.x_mm + forward_mm * math.cos(angle) - left_mm * math.sin(angle),
            self.pose.y_mm + forward_mm * math.sin(angle) + left_mm * math.cos(angle),
            self.pose.heading_deg + turn_deg,
        )
