"""The vehicle's C library at the wheel: compiled when it is first needed, fed with the bytes of the line."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from larics_host.errors import UserError
from larics_host.sources import source_root

SHIM = Path(__file__).with_name("controller.c")
STATES = (
    *("waiting", "silent", "foreign", "restarted", "unproven", "faulty", "stalled", "frozen", "damaged"),
    *("overrun", "no marker", "unusable", "strayed", "imprecise", "good", "no STATUS"),
)  # in the order of LARICS_WAITING .. LARICS_NO_STATUS
_MAX_FRAME = 130


def compiler() -> str | None:
    """The C compiler of this computer, or None."""
    return next((name for name in ("cc", "gcc", "clang") if shutil.which(name)), None)


@cache
def library() -> ctypes.CDLL:
    """The library and its shim as a ctypes.CDLL. UserError without a compiler or the sources."""
    name = compiler()
    sources = source_root() / "firmware" / "vehicle" / "src"
    if name is None:
        raise UserError("no C compiler: install gcc or clang, or use --controller python")
    with tempfile.TemporaryDirectory(prefix="larics-controller-") as folder:
        target = Path(folder) / "controller.so"
        command = [name, "-std=c99", "-O2", "-shared", "-fPIC", "-I", str(sources), "-o", str(target)]
        files = [str(SHIM), *map(str, sorted(sources.glob("*.c")))]
        result = subprocess.run([*command, *files], capture_output=True, text=True)
        if result.returncode:
            raise UserError("the C controller cannot be compiled: " + result.stderr.strip().splitlines()[0])
        loaded = ctypes.CDLL(str(target))
    loaded.controller_new.restype = ctypes.c_void_p
    loaded.controller_ask.restype = loaded.controller_odometry.restype = ctypes.c_size_t
    for function, types in {
        "free": [ctypes.c_void_p],
        "supervise": [ctypes.c_void_p, ctypes.POINTER(ctypes.c_uint32)],
        "receive": [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_uint32],
        "ask": [ctypes.c_void_p, ctypes.c_uint32, ctypes.c_char_p],
        "roll": [ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_uint16, ctypes.c_uint32],
        "odometry": [ctypes.c_void_p, ctypes.c_uint32, ctypes.c_char_p],
        "step": [ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint32, ctypes.POINTER(ctypes.c_int32)],
        "stop": [ctypes.c_void_p],
        "start": [ctypes.c_void_p],
        "hold": [ctypes.c_void_p, ctypes.c_int],
        "route": [ctypes.c_void_p, ctypes.POINTER(ctypes.c_uint16), ctypes.c_uint16, ctypes.c_int16],
        "see": [ctypes.c_void_p, ctypes.c_int32, ctypes.POINTER(ctypes.c_int32)],
    }.items():
        getattr(loaded, "controller_" + function).argtypes = types
    return loaded


class CController:
    """larics_supervisor, larics_drive and larics_wheels behind the calls of larics_vehicle.approach.Approach.

    limits        as Approach's, by name
    supervision   None: every decoded message is taken; else a dict of baud, buffer_bytes, silent_ms,
                  stalled_ms, challenge_ms, answer_ms, now_ms, seed, and the limits of the pose
    After `step`: state, speed_mm_s, turn_cdeg_s, left_id, is_end; camera_state (a word of STATES), accepted.
    ValueError for a limit outside its range.
    """

    _LIMITS = (
        *("speed_mm_s", "turn_cdeg_s", "accel_mm_s2", "turn_accel_cdeg_s2", "stale_ms", "center_mm10"),
        *("align_cdeg", "leg_mm"),
    )
    _SUPERVISION = (
        *("baud", "buffer_bytes", "silent_ms", "stalled_ms", "challenge_ms", "answer_ms", "now_ms", "seed"),
        *("most_sigma_mm10", "most_sigma_cdeg", "most_carried_ms", "most_way_mm"),
    )

    def __init__(self, limits: Mapping[str, int], supervision: Mapping[str, int] | None = None) -> None:
        self._library = library()
        numbers = (ctypes.c_int32 * 8)(*(limits[name] for name in self._LIMITS))
        self._self = self._library.controller_new(numbers, supervision is not None)
        if not self._self:
            raise ValueError("a limit of the drive is outside its range: %s" % limits)
        usual = dict.fromkeys(self._SUPERVISION, 0) | {"baud": 115200}
        usual |= dict.fromkeys(self._SUPERVISION[8:], 65535)  # not judged
        chosen = {**usual, **(supervision or {})}
        words = (ctypes.c_uint32 * len(chosen))(*(chosen[name] for name in self._SUPERVISION))
        self._library.controller_supervise(self._self, words)
        self._told = (ctypes.c_int32 * 7)()
        self._seen = (ctypes.c_int32 * 4)()
        self._frame = ctypes.create_string_buffer(_MAX_FRAME)
        self.state, self.speed_mm_s, self.turn_cdeg_s, self.left_id, self.is_end = 1, 0, 0, 0, False
        self.camera_state, self.accepted = STATES[0], 0

    def __del__(self):
        if getattr(self, "_self", None):
            self._library.controller_free(self._self)

    def receive(self, data: bytes, now_ms: int) -> None:
        """What came over the line since the last call."""
        self._library.controller_receive(self._self, data, len(data), now_ms & 0xFFFFFFFF)

    def ask(self, now_ms: int) -> bytes:
        """Bytes to send to the camera, b"" when nothing is due."""
        size = self._library.controller_ask(self._self, now_ms & 0xFFFFFFFF, self._frame)
        return self._frame.raw[:size]

    def roll(self, left_um: int, right_um: int, track_mm: int, now_us: int) -> bool:
        """What the encoders of both wheels counted since the last call; False when that cannot be."""
        return bool(
            self._library.controller_roll(self._self, left_um, right_um, track_mm, now_us & 0xFFFFFFFF)
        )

    def odometry(self, now_us: int) -> bytes:
        """An ODOMETRY of the wheels, to be sent to the camera."""
        size = self._library.controller_odometry(self._self, now_us & 0xFFFFFFFF, self._frame)
        return self._frame.raw[:size]

    def step(self, elapsed_ms: int, now_ms: int = 0) -> int:
        self._library.controller_step(self._self, now_ms & 0xFFFFFFFF, elapsed_ms, self._told)
        self.state, self.speed_mm_s, self.turn_cdeg_s, self.left_id, end, camera, self.accepted = self._told
        self.is_end = bool(end)
        self.camera_state = STATES[camera]
        return int(self.state)

    def stop(self) -> None:
        self._library.controller_stop(self._self)

    def start(self) -> None:
        self._library.controller_start(self._self)

    def hold(self, is_held: bool) -> None:
        self._library.controller_hold(self._self, is_held)

    def route(self, ids: Sequence[int], start: int = -1) -> bool:
        """False when that cannot be a route."""
        return bool(
            self._library.controller_route(self._self, (ctypes.c_uint16 * len(ids))(*ids), len(ids), start)
        )

    def see(self, marker_id: int) -> tuple[int, ...]:
        """(what it means, position, next position, missed). -1: out of sight, means -1; -2: passed by."""
        self._library.controller_see(self._self, marker_id, self._seen)
        return tuple(self._seen)
