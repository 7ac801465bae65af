"""How the vehicle moves, as far as measurements tell: integer helpers, and speed and turn rate.

Times are in 100 us ("_h"), which keeps every product within 30 bits.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import atan2_turn16, cdeg_from_turn16, cos_q14, sin_q14, turn16_from_cdeg

_MAX_SPEED_MM10_S = const(100000)
_MAX_TURN_CDEG_S = const(72000)
_SMOOTH_H = const(1000)  # time constant of the estimates
_LONGEST_MS = const(3000)
_TURN_MS = const(500)  # a turn is carried on for so long


def times_q14(value, factor_q14):
    """value * factor / 2**14, rounded; |value| < 2**21, |factor| <= 2**14."""
    return ((value >> 6) * factor_q14 + ((value & 63) * factor_q14 >> 6) + 128) >> 8


def scaled_q14(value, factor_q14):
    """value * factor / 2**14 for |value| < 2**30, |factor| <= 2**14."""
    return (value >> 14) * factor_q14 + ((value & 16383) * factor_q14 >> 14)


def grown(acceleration, time_h, limit):
    """Half the acceleration (below 2**18) times the time squared, at most `limit`."""
    if time_h > 30000:
        return limit
    time_ms = time_h // 10
    return min(limit, (acceleration >> 4) * time_ms // 1000 * time_ms // 125)


def direction_cdeg(x, y):
    """Direction of a vector, 0..35999, of components within +-2**29; 0 for the null vector."""
    while abs(x) >= 1 << 21 or abs(y) >= 1 << 21:
        x >>= 1
        y >>= 1
    return cdeg_from_turn16(atan2_turn16(y, x))


def _rate(difference, time_h, limit):
    """Change per second of a difference over a time, clamped."""
    if abs(difference) > 100000:
        return limit if difference > 0 else -limit
    return max(-limit, min(limit, difference * 10000 // time_h))


class Motion:
    """Speed and turn rate in the vehicle frame: forward, left (0.1 mm/s) and turn (0.01 degrees/s)."""

    def __init__(self):
        self.stop()

    def stop(self):
        """Nothing is known of the motion."""
        self.forward = self.left = self.turn = 0

    def learn(self, dx, dy, heading_cdeg, turned_cdeg, time_h, first):
        """Takes what was driven (map frame, 0.1 mm) from a heading on in a time; `first`: believe it all."""
        middle = turn16_from_cdeg(heading_cdeg + turned_cdeg // 2)
        sin, cos = sin_q14(middle), cos_q14(middle)
        dx, dy = max(-100000, min(100000, dx)), max(-100000, min(100000, dy))
        forward = _rate(times_q14(dx, cos) + times_q14(dy, sin), time_h, _MAX_SPEED_MM10_S)
        left = _rate(times_q14(dy, cos) - times_q14(dx, sin), time_h, _MAX_SPEED_MM10_S)
        turn = _rate(turned_cdeg, time_h, _MAX_TURN_CDEG_S)
        share_q8 = 256 if first else (time_h << 8) // (time_h + _SMOOTH_H)
        self.forward += (forward - self.forward) * share_q8 >> 8
        self.left += (left - self.left) * share_q8 >> 8
        self.turn += (turn - self.turn) * share_q8 >> 8

    def carry(self, pose, time_h):
        """Moves pose (x, y, heading, not wrapped) on along an arc, then straight: vehicles do not turn for
        long, and nobody knows for how long."""
        time_ms = min(time_h // 10, _LONGEST_MS)
        turn_ms = min(time_ms, _TURN_MS)
        turned = self.turn * turn_ms // 1000
        self._advance(pose, pose[2] + turned // 2, turn_ms)
        pose[2] += turned
        if time_ms > turn_ms:
            self._advance(pose, pose[2], time_ms - turn_ms)

    def _advance(self, pose, heading_cdeg, time_ms):
        turn16 = turn16_from_cdeg(heading_cdeg)
        sin, cos = sin_q14(turn16), cos_q14(turn16)
        ahead, aside = self.forward * time_ms // 1000, self.left * time_ms // 1000
        pose[0] += times_q14(ahead, cos) - times_q14(aside, sin)
        pose[1] += times_q14(ahead, sin) + times_q14(aside, cos)

    def sideways_mm10_s2(self):
        """The acceleration that it takes to turn like this at this speed, at most 5 m/s2."""
        return min((abs(self.forward) >> 4) * (abs(self.turn) >> 2) // 90, 50000)
