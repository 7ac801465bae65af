"""The covariance of a pose that odometry carries on (locate.carrier): it follows every 64 mm of way, which at
2 m/s are there in each frame."""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr32

_COVARIANCE_XX = const(0)
_COVARIANCE_XY = const(1)
_COVARIANCE_YY = const(2)
_COVARIANCE_XT = const(3)
_COVARIANCE_YT = const(4)
_COVARIANCE_TT = const(5)
_COVARIANCE_SCALE = const(6)
_COVARIANCE_TURNS = const(7)
_COVARIANCE_BENT_X = const(8)
_COVARIANCE_BENT_Y = const(9)
_COVARIANCE_SCALE_SIGMA = const(10)
_COVARIANCE_DRIFT_SIGMA = const(11)
_COVARIANCE_TURN_SIGMA = const(12)
_COVARIANCE_NOISE_Q4 = const(13)
_COVARIANCE_HASTE_US = const(14)
_COVARIANCE_TRACK_Q4 = const(15)
_COVARIANCE_SIGMA_X = const(16)
_COVARIANCE_SIGMA_Y = const(17)
_COVARIANCE_SIGMA_CDEG = const(18)
_COVARIANCE_CORRELATION = const(19)

_WAY_NOISE_Q20 = const(2097)  # 0.0025 mm2 of variance a mm of way and wheel, OdometryNoise's unit
_TURN_NOISE_Q16 = const(93207)  # ... with a track of 300 mm
_USUAL_NOISE = const(19)  # 2500 / 128: of locate.uncertainty
_NO_NOISE_Q4 = const(192)
_MOST_NOISE = const(1 << 24)
_MOST = const(1 << 25)  # 1.4 m ...
_MOST_TURN = const(1 << 27)  # ... and 41 degrees: products stay within 30 bits
_MOST_SINCE = const(11000)
_MOST_MM = const(16383)
_MOST_SHARE = const(23000)  # mrad Q4: two squares stay within 30 bits
_BENT_Q8 = const(230400)  # of the heading, (30 mrad)**2: with less a way does not get shorter to speak of
_MOST_BENT = const(1 << 18)  # 1 m


@micropython.viper
def grow(
    mask: int, sign: int, items: ptr32, px: int, py: int, since: int, speed: int, way_q4: int, turn_q4: int,
    way_mm: int, turned: int,
):  # fmt: skip
    """A way of (px, py), 0.1 mm Q4, after which the covariance grows, and its sigmas. mask, sign: any.

    since: its length, 0.1 mm, turns of wheels counted; speed: mm/s, up to 8000; way_q4, turn_q4: logarithms
    of the noise's loudness (locate.wheel_noise); way_mm: since the marker; turned: the largest turn since
    then, mrad."""
    mask = 0x3FFFFFFF
    sign = 0x20000000
    xx = ((int(items[_COVARIANCE_XX]) & mask) ^ sign) - sign
    yy = ((int(items[_COVARIANCE_YY]) & mask) ^ sign) - sign
    tt = int(items[_COVARIANCE_TT])
    if xx > _MOST or yy > _MOST or tt > _MOST_TURN:
        return  # it is of no use any more
    if px > 160000:
        px = 160000
    if px < 0 - 160000:
        px = 0 - 160000
    if py > 160000:
        py = 160000
    if py < 0 - 160000:
        py = 0 - 160000
    mx = (px >> 4) * 26843 >> 14  # Q14 of a metre
    my = (py >> 4) * 26843 >> 14
    if since < 1:
        since = 1
    if since > _MOST_SINCE:
        since = _MOST_SINCE
    # the noise at this speed
    noise_q4 = ((int(items[_COVARIANCE_NOISE_Q4]) & mask) ^ sign) - sign
    haste = int(items[_COVARIANCE_HASTE_US])
    if haste:
        haste = haste * speed >> 7
        unit = _USUAL_NOISE
        hasty_q4 = 0
        if haste > 0:
            while haste >= 2 * unit:
                unit = unit << 1
                hasty_q4 += 16
            while haste < unit:
                haste = haste << 1
                hasty_q4 -= 16
            hasty_q4 += ((haste - unit) << 4) // unit
        else:
            hasty_q4 = 0 - _NO_NOISE_Q4
        rest = noise_q4 - hasty_q4
        if rest < 0:
            noise_q4 = hasty_q4
        if rest < 8 and rest > 0 - 8:
            noise_q4 += 16
    turn_q4 += noise_q4 + ((int(items[_COVARIANCE_TRACK_Q4]) & mask) ^ sign) - sign
    way_q4 += noise_q4
    # what it makes of the way, then of the turns
    added = since * _WAY_NOISE_Q20 >> 10
    noise_q4 = way_q4
    turned_noise = 0
    k = 0
    while k < 2:
        added = added * (16 + (noise_q4 & 15)) >> 4
        noise_q4 = noise_q4 >> 4
        if noise_q4 < 0 - 30:
            noise_q4 = 0 - 30
        if noise_q4 < 0:
            added = added >> (0 - noise_q4)
        while noise_q4 > 0 and added < _MOST_NOISE:
            added = added << 1
            noise_q4 -= 1
        if added > _MOST_NOISE:
            added = _MOST_NOISE
        if k == 0:
            turned_noise = added >> 10
            added = since * _TURN_NOISE_Q16 >> 14
            noise_q4 = turn_q4
        k += 1
    grown = added >> 2
    added = turned_noise
    # what scale, drift and turn may be wrong by
    scale = (int(items[_COVARIANCE_SCALE_SIGMA]) >> 3) * way_mm >> 13
    if scale > 32767:
        scale = 32767
    was = int(items[_COVARIANCE_SCALE])
    items[_COVARIANCE_SCALE] = scale
    rest = added + (scale * scale >> 4) - (was * was >> 4)
    added = 0
    if rest > 0:
        added = rest
    if turned > _MOST_MM:
        turned = _MOST_MM
    scale = (int(items[_COVARIANCE_DRIFT_SIGMA]) >> 5) * way_mm >> 11
    if scale > _MOST_SHARE:
        scale = _MOST_SHARE
    was = (int(items[_COVARIANCE_TURN_SIGMA]) >> 5) * turned >> 11
    if was > _MOST_SHARE:
        was = _MOST_SHARE
    scale = scale * scale + was * was
    rest = scale - int(items[_COVARIANCE_TURNS])
    items[_COVARIANCE_TURNS] = scale
    if rest > 2 * _MOST_TURN:
        rest = 2 * _MOST_TURN
    if rest > 0:
        grown += rest
    tt += grown >> 1
    xt = ((int(items[_COVARIANCE_XT]) & mask) ^ sign) - sign
    yt = ((int(items[_COVARIANCE_YT]) & mask) ^ sign) - sign
    px = xt - (((tt >> 14) * my + ((tt & 16383) * my >> 14)) >> 3)  # ... and after it
    py = yt + (((tt >> 14) * mx + ((tt & 16383) * mx >> 14)) >> 3)
    items[_COVARIANCE_XT] = px
    items[_COVARIANCE_YT] = py
    rest = xt + px
    xx += added - (((rest >> 14) * my + ((rest & 16383) * my >> 14)) >> 1)
    rest = yt + py
    yy += added + (((rest >> 14) * mx + ((rest & 16383) * mx >> 14)) >> 1)
    xy = ((int(items[_COVARIANCE_XY]) & mask) ^ sign) - sign
    xy += (((px >> 14) * mx + ((px & 16383) * mx >> 14)) >> 1) - (
        ((yt >> 14) * my + ((yt & 16383) * my >> 14)) >> 1
    )
    if tt > _BENT_Q8:
        # A heading that is wrong, to either side, makes the way shorter: by half of its square, of which
        # the root mean square is 0.87 of the variance when it was wrong from the start, and 0.76 when it
        # grows so.
        rest = ((int(items[_COVARIANCE_BENT_X]) & mask) ^ sign) - sign
        was = ((int(items[_COVARIANCE_BENT_Y]) & mask) ^ sign) - sign
        px = rest >> 4  # mm Q4
        py = was >> 4
        rest += (((tt >> 14) * mx + ((tt & 16383) * mx >> 14)) >> 4) * 13 >> 10
        was += (((tt >> 14) * my + ((tt & 16383) * my >> 14)) >> 4) * 13 >> 10
        if rest > _MOST_BENT:
            rest = _MOST_BENT
        if rest < 0 - _MOST_BENT:
            rest = 0 - _MOST_BENT
        if was > _MOST_BENT:
            was = _MOST_BENT
        if was < 0 - _MOST_BENT:
            was = 0 - _MOST_BENT
        items[_COVARIANCE_BENT_X] = rest
        items[_COVARIANCE_BENT_Y] = was
        rest = rest >> 4
        was = was >> 4
        added = (rest * rest >> 4) - (px * px >> 4)
        if added > 0:
            xx += added
        xy += (rest * was >> 4) - (px * py >> 4)
        added = (was * was >> 4) - (py * py >> 4)
        if added > 0:
            yy += added
    tt += grown - (grown >> 1)
    items[_COVARIANCE_XX] = xx
    items[_COVARIANCE_XY] = xy
    items[_COVARIANCE_YY] = yy
    items[_COVARIANCE_TT] = tt
    px = 0
    py = 0
    k = 0
    while k < 3:  # standard deviations
        value = tt
        if k == 0:
            value = xx
        if k == 1:
            value = yy
        if value < 1:
            value = 1
        if k < 2:
            value = value << 2
        root = 1
        if value > 1:
            rest = value
            while rest:
                rest = rest >> 2
                root = root << 1
            rest = (root + value // root) >> 1
            while rest < root:
                root = rest
                rest = (root + value // root) >> 1
        if k == 0:
            px = root  # mm Q3
        if k == 1:
            py = root
        if k == 2:
            items[_COVARIANCE_SIGMA_CDEG] = (root * 358 + 999) // 1000  # 1 mrad Q4 is 0.358 of 0.01 degrees
        k += 1
    items[_COVARIANCE_SIGMA_X] = (px * 10 + 15) >> 3
    items[_COVARIANCE_SIGMA_Y] = (py * 10 + 15) >> 3
    root = px * py >> 2
    while xy > 65535 or xy < 0 - 65535:
        xy = xy >> 1
        root = root >> 1
    if root < 1:
        root = 1
    xy = (xy << 14) // root
    if xy > 16384:
        xy = 16384
    if xy < 0 - 16384:
        xy = 0 - 16384
    items[_COVARIANCE_CORRELATION] = xy
