"""What a rolling shutter did to a marker, undone (locate.rolling): bytecode would take half as long for it as
for the pose."""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr32

_ROLLING_DX = const(0)
_ROLLING_DY = const(1)
_ROLLING_PASSED_MS = const(2)
_ROLLING_TURN = const(3)
_ROLLING_TOLD = const(4)
_ROLLING_ROW = const(5)
_ROLLING_SHEAR = const(6)
_ROLLING_DOWN_X = const(7)
_ROLLING_DOWN_Y = const(8)
_ROLLING_X = const(9)
_ROLLING_Y = const(10)
_ROLLING_HEADING = const(11)
_ROLLING_LAST_US = const(12)
_ROLLING_LAST_X = const(13)
_ROLLING_LAST_Y = const(14)
_ROLLING_LAST_HEADING = const(15)

_LONGEST_US = const(500000)  # between two frames: over more the mean speed is not that of now
_FASTEST = const(80)  # 0.1 mm a millisecond: 8 m/s; faster is no vehicle
_MOST_CDEG_S = const(30000)

_LINE_PERCENT = const(143)  # of the ring's radius: where the orientation line tells its direction


@micropython.viper
def follow(
    mask: int, sign: int, items: ptr32, x: int, y: int, heading: int, time_us: int, known: int
) -> int:  # fmt: skip
    """Odometry tells that pose of a frame; known: it has not jumped since the one before. 1 when the vehicle
    has moved since then by as much as a vehicle can: items tell how. mask, sign: any."""
    mask = 0x3FFFFFFF
    sign = 0x20000000
    moves = 0
    passed_us = (time_us - int(items[_ROLLING_LAST_US])) & mask
    if known:
        if passed_us <= _LONGEST_US:
            passed_ms = passed_us // 1000
            if passed_ms < 1:
                passed_ms = 1
            dx = x - (((int(items[_ROLLING_LAST_X]) & mask) ^ sign) - sign)
            dy = y - (((int(items[_ROLLING_LAST_Y]) & mask) ^ sign) - sign)
            was = int(items[_ROLLING_LAST_HEADING])
            turn = ((heading - was + 54000) % 36000 - 18000) * 1000 // passed_ms
            if dx | dy | turn:
                moves = 1
            far = _FASTEST * passed_ms
            if dx > far or dx < 0 - far or dy > far or dy < 0 - far:
                moves = 0
            if turn > _MOST_CDEG_S or turn < 0 - _MOST_CDEG_S:
                moves = 0
            if moves:
                items[_ROLLING_DX] = dx
                items[_ROLLING_DY] = dy
                items[_ROLLING_PASSED_MS] = passed_ms
                items[_ROLLING_TURN] = turn
                items[_ROLLING_TOLD] = was + turn * passed_ms // 2000
    items[_ROLLING_LAST_US] = time_us & mask
    items[_ROLLING_LAST_X] = x
    items[_ROLLING_LAST_Y] = y
    items[_ROLLING_LAST_HEADING] = heading
    return moves


@micropython.viper
def unroll(
    mask: int, sign: int, items: ptr32, sines: ptr8, x: int, y: int, heading: int, row_q8: int,
    radius_q8: int,
):  # fmt: skip
    """A marker at (x, y) with that heading (0.1 mm within 30000, 0.01 degrees), in a row so far below the
    middle, with a ring of that radius, put right into X, Y and HEADING of the items, which tell how the
    vehicle moves. mask, sign: any; sines: arith.tables.QUARTER_SINE_Q14."""
    mask = 0x3FFFFFFF
    sign = 0x20000000
    turn = ((int(items[_ROLLING_TURN]) & mask) ^ sign) - sign
    angle = ((((int(items[_ROLLING_TOLD]) & mask) ^ sign) - sign) % 36000 * 2048 + 562) // 1125
    ahead_mm_s = 0
    left_mm_s = 0
    sin = 0
    cos = 0
    k = 0
    while k < 4:  # sine and cosine of the vehicle's heading, then of the marker's
        if k == 2:
            dx = ((int(items[_ROLLING_DX]) & mask) ^ sign) - sign
            dy = ((int(items[_ROLLING_DY]) & mask) ^ sign) - sign
            ahead_mm_s = ((dx * cos + dy * sin) >> 14) * 100 // int(items[_ROLLING_PASSED_MS])
            left_mm_s = ((dy * cos - dx * sin) >> 14) * 100 // int(items[_ROLLING_PASSED_MS])
            angle = (heading % 36000 * 2048 + 562) // 1125
        at = angle
        if k & 1:
            at += 16384
        at = at & 65535
        below = 0
        if at >= 32768:
            at -= 32768
            below = 1
        if at > 16384:
            at = 32768 - at
        rest = at & 63
        at = at >> 6 << 1
        value = int(sines[at]) | int(sines[at + 1]) << 8
        if rest:
            value += (((int(sines[at + 2]) | int(sines[at + 3]) << 8) - value) * rest + 32) >> 6
        if below:
            value = 0 - value
        if k & 1:
            cos = value
        else:
            sin = value
        k += 1
    row_16ns = ((int(items[_ROLLING_ROW]) & mask) ^ sign) - sign
    late_16us = (row_q8 >> 4) * row_16ns // 16000
    # the marker's motion in the vehicle frame
    along_x = y * turn // 57300 - ahead_mm_s
    along_y = 0 - x * turn // 57300 - left_mm_s
    items[_ROLLING_X] = x - along_x * late_16us // 6250
    items[_ROLLING_Y] = y - along_y * late_16us // 6250
    aside_mm_s = (along_y * cos - along_x * sin) >> 14
    down_x = ((int(items[_ROLLING_DOWN_X]) & mask) ^ sign) - sign
    down_y = ((int(items[_ROLLING_DOWN_Y]) & mask) ^ sign) - sign
    rows_q14 = (down_x * cos + down_y * sin) >> 14
    shear = ((int(items[_ROLLING_SHEAR]) & mask) ^ sign) - sign
    turned = (aside_mm_s * rows_q14 >> 14) * shear // 62500
    line_16us = radius_q8 * _LINE_PERCENT // 25600 * row_16ns // 1000
    turned -= turn * (late_16us + (line_16us * rows_q14 >> 14)) // 62500
    items[_ROLLING_HEADING] = (heading - turned) % 36000
