"""Poses of the vehicle's odometry with their times, and its clock in terms of the camera's, for each message:
at up to 100 a second, bytecode would take a tenth of a small board (locate.odometry, locate.vehicle_clock).

Times are in microseconds modulo 2**30, places in 0.1 mm, angles in 0.01 degrees.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr32

_MASK = const(0x3FFFFFFF)
_SIGN = const(0x20000000)

# items of `clock`
_CLOCK_KNOWN = const(0)
_CLOCK_OFFSET_US = const(1)
_CLOCK_REST_NS = const(2)
_CLOCK_HEARD_US = const(3)
_CLOCK_DRIFT_PPM = const(4)
_CLOCK_HAS_LAST = const(5)  # the earliest message of the span before
# 6, 7, 8: when it came, what it told of the clocks, how long it may have waited
_CLOCK_SPAN_MS = const(9)
_CLOCK_BEGAN_US = const(10)
_CLOCK_BEGAN_OFFSET_US = const(11)
_CLOCK_MESSAGES = const(12)
_CLOCK_EARLIEST_US = const(13)
_CLOCK_EARLIEST_OFFSET_US = const(14)
_CLOCK_WAITED_US = const(15)
_CLOCK_LEAST_US = const(16)  # by which a message was late, against the span's beginning and the drift
_CLOCK_LATE_US = const(17)  # ... against the estimate
_CLOCK_ARRIVED_US = const(18)  # the message that is heard
_CLOCK_SENT_US = const(19)
_CLOCK_READ_US = const(20)  # for how long it may have waited to be read
_FORGOTTEN = const(18)  # that are forgotten

_LEAK_PPM = const(400)  # above what crystals drift
_LEAP_US = const(1000000)  # no clock drifts, and no message waits, for so long
_FIRST_SPAN_MS = const(2000)  # of messages whose earliest one shows the drift; the longest one is
_LONGEST_SPAN_MS = const(8000)
_LEAST_MESSAGES = const(8)  # in a span

# `ring`: rows of items, one row a pose, ...
_TIME_US = const(0)
_X_MM10 = const(1)
_Y_MM10 = const(2)
_HEADING_CDEG = const(3)
_WAY_MM10 = const(4)
_TURN_CDEG = const(5)
_AGE_US = const(6)  # of `out` only
_ROW = const(6)
_LAST_ROW = const(63)  # one less than a power of two
_NEWEST = const(384)  # ... then which row is the newest, how many there are,
_COUNT = const(385)
_HEARD = const(386)  # what the newest message told
_EPOCH = const(387)
_FLAGS = const(388)
_SAMPLED_US = const(389)
_BEFORE_US = const(390)  # when the line was read before
_LINE_US = const(391)  # a message's time on the line
_JUMPS = const(392)
_JUMPY = const(393)
_WILD = const(394)

# `values` of an ODOMETRY message
_TIME_US_TOLD = const(0)
_AGE_US_TOLD = const(1)
_X_MM10_TOLD = const(2)
_Y_MM10_TOLD = const(3)
_HEADING_CDEG_TOLD = const(4)
_EPOCH_TOLD = const(5)
_FLAGS_TOLD = const(6)

_STALE_AFTER_US = const(1000000)  # no frame that is still processed was exposed so long ago
_BACK_US = const(1000000)  # a time that is further back is another clock's, not a message overtaken
_JUMP = const(4)  # a jump counts as much as so many good poses;
_WILD_ABOVE = const(8)  # beyond this odometry is wild, until it is at nought again
_WILDEST = const(16)

_GAP_US = const(1000000)  # between two poses nobody knows the way
_FASTEST_MM10_MS = const(200)  # 20 m/s, and _TURN_CDEG_MS (10 turns a second), is no drive but a jump
_TURN_CDEG_MS = const(360)
_SLACK = const(500)  # 50 mm, 5 degrees
_AHEAD_US = const(200000)  # for so long the last motion is carried on ...
_BASE_US = const(10000)  # ... as it was over at least so long


# `path` and `sums` of a pose that is carried
_PATH_HEADING_Q6 = const(0)
_PATH_X = const(1)
_PATH_Y = const(2)
_PATH_NEW_X = const(3)
_PATH_NEW_Y = const(4)
_PATH_WAY = const(5)
_PATH_SINCE = const(6)
_PATH_TURNED = const(7)
_PATH_TURNED_MOST = const(8)
_PATH_SPEED = const(9)
_PATH_SCALE_Q12 = const(10)
_PATH_TURN_Q14 = const(11)
_PATH_DRIFT_Q16 = const(12)
_PATH_HALF_TRACK = const(13)
_SUMS_FORWARD = const(0)
_SUMS_DRIVEN = const(1)
_SUMS_WAY = const(2)
_SUMS_TURNED = const(3)

_FURTHEST_MM10 = const(160000)  # of a way that is compared, and so much in 0.01 degrees
_FASTEST_MM_S = const(8000)
_LONGEST_WAY = const(1 << 24)
_MOST_TURNED = const(180000)


@micropython.viper
def hear(mask: int, sign: int, clock: ptr32) -> int:
    """Takes the message whose times are in `clock`. 0 when the two clocks leapt apart: nothing is known; 2
    when a span of messages is over, of which the caller has to learn; else 1. mask, sign: any."""
    mask = _MASK
    sign = _SIGN
    arrived_us = int(clock[_CLOCK_ARRIVED_US])
    offset_us = (arrived_us - int(clock[_CLOCK_SENT_US])) & mask
    drift_ppm = ((int(clock[_CLOCK_DRIFT_PPM]) & mask) ^ sign) - sign
    now_us = offset_us
    late_us = 0
    known = 1
    if int(clock[_CLOCK_KNOWN]):
        passed_us = (((arrived_us - int(clock[_CLOCK_HEARD_US])) & mask) ^ sign) - sign
        passed_ms = 0
        if passed_us > 0:
            passed_ms = passed_us // 1000
        clock[_CLOCK_HEARD_US] = ((int(clock[_CLOCK_HEARD_US]) - sign + passed_ms * 1000) & mask) ^ sign
        # the offset grows with the drift, and by the leak, which makes room for a later least delay
        if passed_ms > _LONGEST_SPAN_MS:
            passed_ms = _LONGEST_SPAN_MS
        grown_ns = passed_ms * (drift_ppm + _LEAK_PPM) + int(clock[_CLOCK_REST_NS])
        grown_us = grown_ns // 1000
        clock[_CLOCK_REST_NS] = grown_ns - grown_us * 1000
        now_us = ((int(clock[_CLOCK_OFFSET_US]) - sign + grown_us) & mask) ^ sign
        late_us = (((offset_us - now_us) & mask) ^ sign) - sign
        if late_us < 0 - _LEAP_US or late_us > _LEAP_US:
            known = 0
            clock[_CLOCK_KNOWN] = 0
        if late_us < 0:
            now_us = offset_us
            late_us = 0
    if int(clock[_CLOCK_KNOWN]) == 0:
        k = 0
        while k < _FORGOTTEN:
            clock[k] = 0
            k += 1
        drift_ppm = 0
        now_us = offset_us
        late_us = 0
        clock[_CLOCK_KNOWN] = 1
        clock[_CLOCK_HEARD_US] = arrived_us
        clock[_CLOCK_SPAN_MS] = _FIRST_SPAN_MS
        clock[_CLOCK_BEGAN_US] = arrived_us
        clock[_CLOCK_BEGAN_OFFSET_US] = offset_us
        clock[_CLOCK_LEAST_US] = _LEAP_US
        clock[_CLOCK_LATE_US] = _LEAP_US
    clock[_CLOCK_OFFSET_US] = now_us
    anew = 0
    if late_us < int(clock[_CLOCK_LATE_US]):
        clock[_CLOCK_LATE_US] = late_us
    clock[_CLOCK_MESSAGES] = int(clock[_CLOCK_MESSAGES]) + 1
    span_us = (((arrived_us - int(clock[_CLOCK_BEGAN_US])) & mask) ^ sign) - sign
    span_ms = 0
    if span_us > 0:
        span_ms = span_us // 1000
    if span_ms > 4 * _LONGEST_SPAN_MS:  # a long silence says nothing of the drift
        clock[_CLOCK_HAS_LAST] = 0
        anew = 1
    else:
        against_us = (((offset_us - int(clock[_CLOCK_BEGAN_OFFSET_US])) & mask) ^ sign) - sign
        against_us -= span_ms * drift_ppm // 1000
        if against_us < ((int(clock[_CLOCK_LEAST_US]) & mask) ^ sign) - sign:
            clock[_CLOCK_LEAST_US] = against_us
            clock[_CLOCK_EARLIEST_US] = arrived_us
            clock[_CLOCK_EARLIEST_OFFSET_US] = offset_us
            clock[_CLOCK_WAITED_US] = int(clock[_CLOCK_READ_US])
        if span_ms >= int(clock[_CLOCK_SPAN_MS]):
            if int(clock[_CLOCK_MESSAGES]) >= _LEAST_MESSAGES:
                anew = 1
    if anew:
        known = 2
    return known


@micropython.viper
def admit(mask: int, sign: int, values: ptr32, ring: ptr32, clock: ptr32, now_us: int) -> int:
    """A message was read: puts its times into `clock`; 0 when it came twice, or out of order. mask, sign:
    any."""
    mask = _MASK
    sign = _SIGN
    count = int(ring[_COUNT])
    sampled_us = int(values[_TIME_US_TOLD])
    anew = 0
    if int(ring[_HEARD]):
        if int(values[_EPOCH_TOLD]) != int(ring[_EPOCH]):
            anew = 1
    if anew == 0:
        if count:
            step_us = (((sampled_us - int(ring[_SAMPLED_US])) & mask) ^ sign) - sign
            if step_us <= 0:
                if step_us > 0 - _BACK_US:
                    return 0
                anew = 2
    if anew:
        if count:
            ring[_JUMPS] = (int(ring[_JUMPS]) + 1) & mask
        ring[_COUNT] = 0
        ring[_JUMPY] = int(ring[_JUMPY]) + _JUMP
        if anew == 2:
            clock[_CLOCK_KNOWN] = 0
    arrived_us = (now_us - int(ring[_LINE_US])) & mask
    waited_us = (((now_us - int(ring[_BEFORE_US])) & mask) ^ sign) - sign
    if waited_us < 0:
        waited_us = 0
    clock[_CLOCK_ARRIVED_US] = arrived_us
    clock[_CLOCK_SENT_US] = (sampled_us - sign + int(values[_AGE_US_TOLD]) - sign) & mask
    clock[_CLOCK_READ_US] = waited_us
    return 1


@micropython.viper
def settle(mask: int, sign: int, values: ptr32, ring: ptr32, clock: ptr32, now_us: int, known: int) -> int:
    """Keeps the pose of a message that was admitted and heard; known: what `hear` gave.

    Sum of 1, when more differs from before than the pose (what it tells, a jump, wild or no more), and 2,
    when it was kept, which a stale one is not."""
    mask = _MASK
    sign = _SIGN
    differs = 0
    if known == 0:
        if int(ring[_COUNT]):
            ring[_JUMPS] = (int(ring[_JUMPS]) + 1) & mask
        ring[_COUNT] = 0
        ring[_JUMPY] = int(ring[_JUMPY]) + _JUMP
    if int(ring[_HEARD]) == 0:
        differs = 1
    if int(values[_EPOCH_TOLD]) != int(ring[_EPOCH]):
        differs = 1
    if int(values[_FLAGS_TOLD]) != int(ring[_FLAGS]):
        differs = 1
    ring[_HEARD] = 1
    ring[_EPOCH] = int(values[_EPOCH_TOLD])
    ring[_FLAGS] = int(values[_FLAGS_TOLD])
    sampled_us = int(values[_TIME_US_TOLD])
    ring[_SAMPLED_US] = sampled_us
    time_us = (sampled_us - sign + int(clock[_CLOCK_OFFSET_US]) - sign) & mask
    jumpy = int(ring[_JUMPY])
    if jumpy > _WILD_ABOVE:
        ring[_WILD] = 1
    if jumpy > _WILDEST:
        jumpy = _WILDEST
    if jumpy:
        differs = 1
    ring[_JUMPY] = jumpy
    stale = 0
    if int(values[_AGE_US_TOLD]) > _STALE_AFTER_US:
        stale = 1
    if (((now_us - time_us) & mask) ^ sign) - sign > _STALE_AFTER_US:
        stale = 1
    if stale:
        return differs
    x = ((int(values[_X_MM10_TOLD]) & mask) ^ sign) - sign
    y = ((int(values[_Y_MM10_TOLD]) & mask) ^ sign) - sign
    heading = int(values[_HEADING_CDEG_TOLD])
    count = int(ring[_COUNT])
    newest = int(ring[_NEWEST])
    was = newest * _ROW
    way = int(ring[was + _WAY_MM10])
    turn = int(ring[was + _TURN_CDEG])
    jumped = 0
    if count:
        passed_us = (((time_us - int(ring[was])) & mask) ^ sign) - sign
        if passed_us <= 0:  # the clocks were set right meanwhile
            time_us = ((int(ring[was]) - sign + 1) & mask) ^ sign
            passed_us = 1
        dx = x - (((int(ring[was + _X_MM10]) & mask) ^ sign) - sign)
        if dx < 0:
            dx = 0 - dx
        dy = y - (((int(ring[was + _Y_MM10]) & mask) ^ sign) - sign)
        if dy < 0:
            dy = 0 - dy
        shift = 0
        while dx > 16383 or dy > 16383:
            dx = dx >> 1
            dy = dy >> 1
            shift += 1
        driven = dx * dx + dy * dy
        if driven > 1:
            root = 1
            at = driven
            while at:
                at = at >> 2
                root = root << 1
            at = (root + driven // root) >> 1
            while at < root:
                root = at
                at = (root + driven // root) >> 1
            driven = root
        driven = driven << shift
        turned = (heading - int(ring[was + _HEADING_CDEG]) + 54000) % 36000 - 18000
        if turned < 0:
            turned = 0 - turned
        if passed_us > _GAP_US:
            count = 0
        else:
            at = passed_us // 1000
            if driven > _SLACK + _FASTEST_MM10_MS * at:
                jumped = 1
            if turned > _SLACK + _TURN_CDEG_MS * at:
                jumped = 1
            if jumped:
                count = 0
                driven = 0
                turned = 0
        way = ((way - sign + driven) & mask) ^ sign
        turn = ((turn - sign + turned) & mask) ^ sign
    newest = (newest + 1) & _LAST_ROW
    ring[_NEWEST] = newest
    if count <= _LAST_ROW:
        count += 1
    ring[_COUNT] = count
    at = newest * _ROW
    ring[at] = time_us
    ring[at + _X_MM10] = x
    ring[at + _Y_MM10] = y
    ring[at + _HEADING_CDEG] = heading
    ring[at + _WAY_MM10] = way
    ring[at + _TURN_CDEG] = turn
    if jumped:
        differs = 1
        ring[_JUMPS] = (int(ring[_JUMPS]) + 1) & mask
        jumpy += _JUMP
        if jumpy > _WILD_ABOVE:
            ring[_WILD] = 1
        if jumpy > _WILDEST:
            jumpy = _WILDEST
    if jumpy:
        jumpy -= 1
        ring[_JUMPY] = jumpy
        if jumpy == 0:
            ring[_WILD] = 0
    return differs + 2


@micropython.viper
def pose_at(mask: int, sign: int, ring: ptr32, time_us: int, out: ptr32) -> int:
    """The pose at a time: out[1..6], items as in a row, and the time since the newest pose, if any.

    0: unknown, out[1..5] as they were; 1: between two poses; 2: the last motion carried on. mask, sign:
    any."""
    mask = _MASK
    sign = _SIGN
    count = int(ring[_COUNT])
    newest = int(ring[_NEWEST])
    out[_AGE_US] = 0
    if count < 2:
        return 0
    state = 0
    after = newest * _ROW
    before = after
    passed_us = (((time_us - int(ring[after])) & mask) ^ sign) - sign
    if passed_us > 0:
        out[_AGE_US] = passed_us
        if passed_us > _AHEAD_US:
            return 0
    last_us = int(ring[after])
    while count > 1 and state == 0:
        count -= 1
        newest = (newest - 1) & _LAST_ROW
        before = newest * _ROW
        if passed_us > 0:
            if (((last_us - int(ring[before])) & mask) ^ sign) - sign >= _BASE_US:
                state = 2
        elif (((time_us - int(ring[before])) & mask) ^ sign) - sign >= 0:
            state = 1
        else:
            after = before
    if state == 0:
        return 0
    between_us = (((int(ring[after]) - int(ring[before])) & mask) ^ sign) - sign
    if between_us < 1:
        between_us = 1
    share_q9 = (((((time_us - int(ring[before])) & mask) ^ sign) - sign) << 9) // between_us
    was = ((int(ring[before + _X_MM10]) & mask) ^ sign) - sign
    now = ((int(ring[after + _X_MM10]) & mask) ^ sign) - sign
    out[_X_MM10] = was + ((now - was) * share_q9 >> 9)
    was = ((int(ring[before + _Y_MM10]) & mask) ^ sign) - sign
    now = ((int(ring[after + _Y_MM10]) & mask) ^ sign) - sign
    out[_Y_MM10] = was + ((now - was) * share_q9 >> 9)
    was = int(ring[before + _HEADING_CDEG])
    now = (int(ring[after + _HEADING_CDEG]) - was + 54000) % 36000 - 18000
    out[_HEADING_CDEG] = (was + (now * share_q9 >> 9)) % 36000
    was = int(ring[before + _WAY_MM10])
    now = (int(ring[after + _WAY_MM10]) - was) & mask
    out[_WAY_MM10] = ((was - sign + (now * share_q9 >> 9)) & mask) ^ sign
    was = int(ring[before + _TURN_CDEG])
    now = (int(ring[after + _TURN_CDEG]) - was) & mask
    out[_TURN_CDEG] = ((was - sign + (now * share_q9 >> 9)) & mask) ^ sign
    return state


@micropython.viper
def advance(
    mask: int, sign: int, path: ptr32, sums: ptr32, sines: ptr8, dx: int, dy: int, turn: int, told: int,
    passed_ms: int, known: int,
) -> int:  # fmt: skip
    """An increment of odometry (0.1 mm in its frame, 0.01 degrees, in so many ms) from its heading `told` on,
    into what is summed up for its shares and, when the pose is known, into its path. Returns the way since
    the covariance grew. mask, sign: any.

    |dx| + |dy| < 7000; sines: arith.tables.QUARTER_SINE_Q14; the shares of way and turn that odometry leaves
    out, and of turn per way (mrad a mm), are each below a quarter."""
    mask = _MASK
    sign = _SIGN
    heading_q6 = int(path[_PATH_HEADING_Q6])
    turn_q6 = turn << 6
    turn_q6 += (turn_q6 >> 4) * (((int(path[_PATH_TURN_Q14]) & mask) ^ sign) - sign) >> 10
    angle = ((told + (turn >> 1)) % 36000 * 2048 + 562) // 1125
    forward = 0
    left = 0
    way = 0
    sin = 0
    cos = 0
    k = 0
    while k < 4:  # sine and cosine of the heading told, then of that of the vehicle, each in the middle
        if k == 2:
            forward = ((dx << 2) * cos + (dy << 2) * sin + 2048) >> 12
            left = ((dy << 2) * cos - (dx << 2) * sin + 2048) >> 12
            way = forward >> 4
            value = (((int(path[_PATH_DRIFT_Q16]) & mask) ^ sign) - sign) * way >> 10
            turn_q6 += value * 37 >> 6
            angle = (((heading_q6 + (turn_q6 >> 1)) >> 6) % 36000 * 2048 + 562) // 1125
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
    # the way of wheels, by which noise grows
    told = turn
    if told < 0:
        told = 0 - told
    angle = way
    if way < 0:
        way = 0 - way
    rest = told * int(path[_PATH_HALF_TRACK]) // 573
    k = ((int(sums[_SUMS_TURNED]) & mask) ^ sign) - sign
    if int(sums[_SUMS_WAY]) < _FURTHEST_MM10:  # beyond it nothing is compared
        if k < _FURTHEST_MM10 and k > 0 - _FURTHEST_MM10:
            sums[_SUMS_FORWARD] = (((int(sums[_SUMS_FORWARD]) & mask) ^ sign) - sign) + angle
            sums[_SUMS_DRIVEN] = int(sums[_SUMS_DRIVEN]) + way
            if rest > way:
                sums[_SUMS_WAY] = int(sums[_SUMS_WAY]) + rest
            else:
                sums[_SUMS_WAY] = int(sums[_SUMS_WAY]) + way
            sums[_SUMS_TURNED] = k + turn
    if rest > way:
        way = rest
    rest = way * 100 // passed_ms
    if rest > _FASTEST_MM_S:
        rest = _FASTEST_MM_S
    path[_PATH_SPEED] = rest
    if known == 0:
        return 0
    k = ((int(path[_PATH_SCALE_Q12]) & mask) ^ sign) - sign
    forward += (forward >> 1) * k >> 11
    left += (left >> 1) * k >> 11
    forward = (forward + 2) >> 2
    left = (left + 2) >> 2
    k = (forward * cos - left * sin + 2048) >> 12
    path[_PATH_X] = (((int(path[_PATH_X]) & mask) ^ sign) - sign) + k
    path[_PATH_NEW_X] = (((int(path[_PATH_NEW_X]) & mask) ^ sign) - sign) + k
    k = (forward * sin + left * cos + 2048) >> 12
    path[_PATH_Y] = (((int(path[_PATH_Y]) & mask) ^ sign) - sign) + k
    path[_PATH_NEW_Y] = (((int(path[_PATH_NEW_Y]) & mask) ^ sign) - sign) + k
    path[_PATH_HEADING_Q6] = (heading_q6 + turn_q6) % 2304000
    k = int(path[_PATH_WAY]) + way
    if k > _LONGEST_WAY:
        k = _LONGEST_WAY
    path[_PATH_WAY] = k
    way += int(path[_PATH_SINCE])
    path[_PATH_SINCE] = way
    k = (((int(path[_PATH_TURNED]) & mask) ^ sign) - sign) + turn
    if k > _MOST_TURNED:
        k = _MOST_TURNED
    if k < 0 - _MOST_TURNED:
        k = 0 - _MOST_TURNED
    path[_PATH_TURNED] = k
    if k < 0:
        k = 0 - k
    if k > int(path[_PATH_TURNED_MOST]):
        path[_PATH_TURNED_MOST] = k
    return way
