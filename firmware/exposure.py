"""Exposure and gain from the picture: short enough against motion blur, quick after a change of light.

The exposure time is the longest that the fastest drive allows without more blur than wanted; what light lacks
then is made up by gain, and only when that is at its end by a longer exposure. In more light the gain goes
first, then the exposure.

While a marker is tracked and its plate is well exposed, nothing is changed. Otherwise the median grey of the
frame is led to its target: a lamp in the picture moves a mean, but not a median. A frame that is all white or
all black tells only the direction, so the step is a large one. After a change, the frames that were under
way are not looked at.

Light is the product of exposure time and gain. Everything is integer.

The grey levels are counted by a viper kernel, also where ulab is present: of 1,200 pixels of a frame
the kernel's histogram takes 51,000 instructions on an emulated Cortex-M7, ulab's median or sort of the same
pixels 370,000 and a single comparison and sum 76,000, and those allocate memory.
"""

from array import array

from larics.kernels.grey import count_greys

_PIXELS = 1500  # about so many are looked at
_IN_FLIGHT = 2  # frames that still have the exposure from before a change
_BLACK = 16  # grey of no light, until a dark frame tells
_BLACK_MOST = 56
_BRIGHTEST = 62  # bins: of 63, so 248 and more, counts as white
_STEP_MOST_Q8 = 10 << 8
_SATURATED_Q8 = 32  # factor for a frame that is all white
_HALF_Q8 = 128
_PLATE_LOW, _PLATE_HIGH = 80, 235  # a tracked marker's plate may be as dark or bright as this
_PLATE_TARGET = 175
_HOLD_Q8 = (160, 410)  # ratio to the target within which nothing is changed
# gain in 1/256 for each decibel of 0.01 * 50: 10 ** (n / 40)
_HALF_DB_Q12 = 4339


def gain_q8(cdb):
    """Linear gain of a gain in 0.01 dB, 1/256; exact to half a decibel."""
    value_q12 = 256 << 4
    for _ in range(cdb // 50):
        value_q12 = value_q12 * _HALF_DB_Q12 >> 12
    return value_q12 >> 4


def gain_cdb(value_q8):
    """The largest gain in steps of half a decibel, 0.01 dB, that is not above this linear gain."""
    cdb, value_q12 = 0, 256 << 4
    while cdb < 4800:
        value_q12 = value_q12 * _HALF_DB_Q12 >> 12
        if value_q12 >> 4 > value_q8:
            break
        cdb += 50
    return cdb


class Exposure:
    """Controls a camera driver; `update` after each processed frame. Settings as in larics.settings."""

    def __init__(self, camera, settings):
        self._camera = camera
        self._counts = array("H", bytes(128))
        self._wait = _IN_FLIGHT
        self._black = _BLACK
        self.configure(settings)

    def configure(self, settings):
        """Takes limits and target from the settings."""
        self._target = settings.target_grey
        self._longest_us = max(settings.exposure_max_us, 10)
        self._gain_most_cdb = settings.gain_max_db10 * 10
        # without a calibration the largest markers that are looked for give the strictest limit
        um_per_px = settings.outer_mm10 * 100 // settings.radius_max_px
        if settings.focal_q8 and settings.ceiling_mm10 > settings.camera_z_mm10:
            above_mm10 = settings.ceiling_mm10 - settings.camera_z_mm10
            um_per_px = above_mm10 * 100 // max(1, settings.focal_q8 >> 8)
        speed_mm_s = max(1, settings.max_speed_mm_s)
        blur_um = (settings.blur_max_q8 * um_per_px) >> 8
        self._blur_us = max(50, min(self._longest_us, blur_um * 1000 // speed_mm_s))

    @property
    def blur_limit_us(self):
        """Longest exposure that keeps the motion blur within its limit."""
        return self._blur_us

    def update(self, frame, width, height, found):
        """`found`: the frame's detections. Returns True when the exposure was changed."""
        if self._wait:
            self._wait -= 1
            return False
        marker = self._tracked(found)
        if marker is not None:
            ratio_q8 = self._plate_ratio(frame, width, height, marker)
        else:
            ratio_q8 = self._frame_ratio(frame, width, height)
        if ratio_q8 == 256:
            return False
        return self._apply(ratio_q8)

    def _tracked(self, found):
        for detection in found:
            if detection.marker_id >= 0:
                return detection
        return None

    def _count(self, frame, width, left, top, right, bottom):
        step = 1
        while (right - left) * (bottom - top) > _PIXELS * step * step:
            step += 1
        count_greys(frame, self._counts, 0, 0, width, left, top, right, bottom, step)

    def _grey(self, share_q8):
        """The grey level (multiple of 4) below which this share of the counted pixels lies."""
        counts = self._counts
        total = 0
        for count in counts:
            total += count
        wanted = total * share_q8 >> 8
        for level in range(64):
            wanted -= counts[level]
            if wanted < 0:
                return level << 2
        return 252

    def _plate_ratio(self, frame, width, height, marker):
        """Factor in 1/256 by which light should change for the plate of a tracked marker; 256: leave it."""
        reach = marker.radius_q8 * 3 // 512
        x, y = marker.x_q8 >> 8, marker.y_q8 >> 8
        self._count(
            frame, width, max(0, x - reach), max(0, y - reach), min(width, x + reach), min(height, y + reach)
        )
        white = self._grey(170)  # two thirds of the plate and more are without ink
        if _PLATE_LOW <= white <= _PLATE_HIGH:
            return 256
        if white >= _BRIGHTEST << 2:  # white as it can be: the rest of the frame tells by how much
            return min(_HALF_Q8, self._frame_ratio(frame, width, height))
        return self._ratio(_PLATE_TARGET, white)

    def _frame_ratio(self, frame, width, height):
        self._count(frame, width, 0, 0, width, height)
        median = self._grey(128)
        if median < 60:  # something in a dark frame is black
            self._black = min(_BLACK_MOST, max(0, self._grey(5)))
        if median >= _BRIGHTEST << 2:
            return _SATURATED_Q8
        ratio_q8 = self._ratio(self._target, median)
        if _HOLD_Q8[0] <= ratio_q8 <= _HOLD_Q8[1]:
            return 256
        return ratio_q8

    def _ratio(self, target, grey):
        black = min(self._black, target // 2)
        if grey <= black + 4:
            return _STEP_MOST_Q8
        return min(_STEP_MOST_Q8, max(_SATURATED_Q8, ((target - black) << 8) // (grey - black)))

    def _apply(self, ratio_q8):
        """Multiplies the light by ratio_q8 / 256, as far as exposure and gain allow."""
        camera = self._camera
        before_us, before_cdb = camera.exposure(), camera.gain()
        light = before_us * (gain_q8(before_cdb) >> 4) >> 4  # in microseconds of gain 1
        light = max(1, max(1, min(light, 1 << 20)) * (ratio_q8 >> 2) >> 6)
        light = min(light, 1 << 20)
        exposure_us = min(light, self._blur_us)
        wanted_cdb = gain_cdb((light << 8) // max(1, exposure_us))
        if wanted_cdb > self._gain_most_cdb:
            wanted_cdb = self._gain_most_cdb
        limit_us = self._longest_us if wanted_cdb == self._gain_most_cdb else self._blur_us
        exposure_us = max(10, min(limit_us, (light << 8) // gain_q8(wanted_cdb)))
        if exposure_us == before_us and wanted_cdb == before_cdb:
            return False
        if wanted_cdb != before_cdb:
            camera.gain(wanted_cdb)
        if exposure_us != before_us:
            camera.exposure(exposure_us)
        self._wait = _IN_FLIGHT
        return True
