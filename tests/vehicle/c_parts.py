"""The vehicle's commands and odometry in C, called from Python: see c_parts.c."""

import ctypes
import subprocess

from tools.vehicle_build import LIBRARY, ROOT, SOURCES, STRICT

_FRAME = 130


class Parts:
    """One vehicle; `folder` takes the compiled library. Its counters begin anew with `init`."""

    def __init__(self, folder):
        target = folder / "parts.so"
        files = [str(ROOT / "tests" / "vehicle" / "c_parts.c"), *map(str, SOURCES)]
        command = ["gcc", *STRICT, "-O1", "-shared", "-fPIC", "-I", str(LIBRARY), *files, "-o", str(target)]
        subprocess.run(command, check=True)
        self._c = ctypes.CDLL(str(target))
        self._c.parts_poll.restype = self._c.parts_odometry.restype = ctypes.c_size_t
        self._frame = ctypes.create_string_buffer(_FRAME)

    def init(self, seed):
        self._c.parts_init(ctypes.c_uint32(seed))

    def begin(self, number, key=0, count=0, values=None):
        given = (ctypes.c_int32 * len(values))(*values) if values is not None else None
        return bool(self._c.parts_begin(number, key, len(values) if values is not None else count, given))

    def poll(self, now_ms):
        size = self._c.parts_poll(ctypes.c_uint32(now_ms), self._frame)
        return self._frame.raw[:size]

    def receive(self, data):
        self._c.parts_receive(bytes(data), ctypes.c_size_t(len(data)))

    def cancel(self):
        self._c.parts_cancel()

    def told(self):
        """(state, reason, detail, count, boot, numbers)"""
        told, values = (ctypes.c_int32 * 5)(), (ctypes.c_int32 * 600)()
        self._c.parts_told(told, values)
        return (*told, list(values))

    def roll(self, left_um, right_um, track_mm, now_us):
        return bool(self._c.parts_roll(left_um, right_um, track_mm, ctypes.c_uint32(now_us)))

    def move(self, forward_um, turn_mcdeg, now_us):
        return bool(self._c.parts_move(forward_um, turn_mcdeg, ctypes.c_uint32(now_us)))

    def place(self, x_mm10, is_slipping=False):
        self._c.parts_place(x_mm10, is_slipping)

    def wheels(self):
        """(x, y, heading in 1/1000 of 0.01 degree, epoch, whether it stands)"""
        told = (ctypes.c_int32 * 5)()
        self._c.parts_wheels(told)
        return tuple(told)

    def reset(self):
        self._c.parts_reset()

    def odometry(self, now_us):
        size = self._c.parts_odometry(ctypes.c_uint32(now_us), self._frame)
        return self._frame.raw[:size]

    def sequence(self):
        """Of the next message that the vehicle sends."""
        return self._c.parts_sequence()

    def resolve(self, rows, ids):
        """The entries of a route in a map of rows (ID, x, y), or None."""
        numbers = [number for row in rows for number in row]
        entries = (ctypes.c_uint16 * max(1, len(ids)))()
        is_route = self._c.parts_resolve(
            (ctypes.c_int32 * len(numbers))(*numbers),
            len(rows),
            (ctypes.c_uint16 * len(ids))(*ids),
            len(ids),
            entries,
        )
        return list(entries[: len(ids)]) if is_route else None
