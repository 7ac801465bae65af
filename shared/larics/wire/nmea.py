"""Measurements as lines of text like those of NMEA 0183, readable in any terminal.

    $PLRCM,frame,age_ms,flags,id,index,count,x_mm,y_mm,z_mm,heading_deg,margin,radius_px,sigma_px,sigma_deg*hh
    $PLRCP,frame,age_ms,marker_age_ms,state,id,x_mm,y_mm,heading_deg,
           sigma_x_mm,sigma_y_mm,correlation,sigma_deg,way_mm,route,next_deg*hh
    $PLRCO,frame,state,epoch,x_mm,y_mm,heading_deg,way_mm,turn_deg,odometry_age_ms*hh
    $PLRCS,version,uptime_s,frames,missed,detections,rejects,drops,crc,line,faults,last,active,state,
           exposure_us,gain_db,grey,rate_hz,frame_us,detect_us,latency_us,free,unanswered,clamped,
           odometry_used,odometry_refused,odometry_stale,odometry_jumps*hh

hh is the exclusive or of everything between $ and *, in hexadecimal; each line ends with CR and LF. What
is unknown or none stays empty. state is T tracking, C coasting, O carried by odometry, L lost. Lines are at
most LONGEST bytes, which is more than the 82 of NMEA when counters are high.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.wire import messages as m

# generated: begin indices (tools/make_protocol.py)
_MARKER_FRAME = const(0)
_MARKER_AGE_US = const(1)
_MARKER_FLAGS = const(2)
_MARKER_ID = const(3)
_MARKER_INDEX = const(4)
_MARKER_COUNT = const(5)
_MARKER_X_MM10 = const(6)
_MARKER_Z_MM10 = const(8)
_MARKER_HEADING_CDEG = const(9)
_MARKER_MARGIN = const(10)
_MARKER_RADIUS_Q8 = const(11)
_MARKER_SIGMA_Q12 = const(12)
_MARKER_SIGMA_MDEG = const(13)
_POSE_FRAME = const(0)
_POSE_AGE_US = const(1)
_POSE_MARKER_AGE_MS = const(2)
_POSE_STATE = const(3)
_POSE_ID = const(4)
_POSE_X_MM10 = const(5)
_POSE_Y_MM10 = const(6)
_POSE_HEADING_CDEG = const(7)
_POSE_SIGMA_X_MM10 = const(8)
_POSE_SIGMA_Y_MM10 = const(9)
_POSE_CORRELATION_Q14 = const(10)
_POSE_SIGMA_CDEG = const(11)
_POSE_WAY_MM = const(12)
_POSE_ROUTE_POSITION = const(13)
_POSE_NEXT_CDEG = const(14)
_STATUS_FIELDS = const(30)
_STATUS_VERSION_MAJOR = const(0)
_STATUS_VERSION_MINOR = const(1)
_STATUS_VERSION_PATCH = const(2)
_STATUS_UPTIME_S = const(4)
_STATUS_STATE = const(15)
_STATUS_GAIN_CDB = const(17)
_STATUS_GREY_MEAN = const(18)
_STATUS_RATE_CHZ = const(19)
_STATUS_FRAME_US = const(20)
_STATUS_LATENCY_US = const(22)
_MOTION_FRAME = const(0)
_MOTION_STATE = const(1)
_MOTION_EPOCH = const(2)
_MOTION_X_MM10 = const(3)
_MOTION_Y_MM10 = const(4)
_MOTION_HEADING_CDEG = const(5)
_MOTION_WAY_MM10 = const(6)
_MOTION_TURN_CDEG = const(7)
_MOTION_ODOMETRY_AGE_US = const(8)
# generated: end indices

LONGEST = const(320)

_STATES = b"LCTO"
_HEX = b"0123456789ABCDEF"


class NmeaEncoder:
    """Encodes like larics.wire.codec.Encoder: n = encode(type, values), then send buffer[:n].

    n is 0 for types that have no line.
    """

    def __init__(self):
        self.buffer = bytearray(LONGEST)
        self._end = 0

    def encode(self, number, values):
        self._end = 0
        if number == m.MARKER:
            self._text(b"$PLRCM")
            self._marker(values)
        elif number == m.POSE:
            self._text(b"$PLRCP")
            self._pose(values)
        elif number == m.MOTION:
            self._text(b"$PLRCO")
            self._motion(values)
        elif number == m.STATUS:
            self._text(b"$PLRCS")
            self._status(values)
        else:
            return 0
        return self._finish()

    def _marker(self, values):
        self._number(values[_MARKER_FRAME], 0)
        self._number(values[_MARKER_AGE_US] // 100, 1)
        self._number(values[_MARKER_FLAGS], 0)
        self._number_unless(values[_MARKER_ID], m.ID_NONE, 0)
        self._number(values[_MARKER_INDEX], 0)
        self._number(values[_MARKER_COUNT], 0)
        seen = not values[_MARKER_FLAGS] & m.MARKER_NONE
        placed = seen and not values[_MARKER_FLAGS] & m.MARKER_NO_OFFSET
        for k in range(_MARKER_X_MM10, _MARKER_Z_MM10 + 1):
            self._number_if(placed, values[k], 1)
        self._number_if(seen, values[_MARKER_HEADING_CDEG], 2)
        self._number_if(seen, values[_MARKER_MARGIN], 0)
        self._number_if(seen, values[_MARKER_RADIUS_Q8] * 10 >> 8, 1)
        sigma_q12 = values[_MARKER_SIGMA_Q12]
        self._number_if(sigma_q12 != m.SIGMA_UNKNOWN, sigma_q12 * 1000 >> 12, 3)
        self._number_unless(values[_MARKER_SIGMA_MDEG], m.SIGMA_UNKNOWN, 3)

    def _pose(self, values):
        self._number(values[_POSE_FRAME], 0)
        self._number(values[_POSE_AGE_US] // 100, 1)
        self._number_unless(values[_POSE_MARKER_AGE_MS], m.AGE_UNKNOWN, 0)
        self._byte(0x2C)
        self._byte(_STATES[values[_POSE_STATE]])
        self._number_unless(values[_POSE_ID], m.ID_NONE, 0)
        self._number_unless(values[_POSE_X_MM10], m.PLACE_UNKNOWN, 1)
        self._number_unless(values[_POSE_Y_MM10], m.PLACE_UNKNOWN, 1)
        self._number_unless(values[_POSE_HEADING_CDEG], m.HEADING_UNKNOWN, 2)
        sigma_x_mm10, sigma_y_mm10 = values[_POSE_SIGMA_X_MM10], values[_POSE_SIGMA_Y_MM10]
        known = sigma_x_mm10 != m.SIGMA_UNKNOWN and sigma_y_mm10 != m.SIGMA_UNKNOWN
        self._number_if(known, sigma_x_mm10, 1)
        self._number_if(known, sigma_y_mm10, 1)
        self._number_if(known, values[_POSE_CORRELATION_Q14] * 1000 // 16384, 3)
        self._number_unless(values[_POSE_SIGMA_CDEG], m.SIGMA_UNKNOWN, 2)
        self._number_unless(values[_POSE_WAY_MM], m.WAY_UNKNOWN, 0)
        self._number_unless(values[_POSE_ROUTE_POSITION], m.ROUTE_NONE, 0)
        self._number_unless(values[_POSE_NEXT_CDEG], m.DIRECTION_NONE, 2)

    def _motion(self, values):
        self._number(values[_MOTION_FRAME], 0)
        self._number(values[_MOTION_STATE], 0)
        self._number(values[_MOTION_EPOCH], 0)
        self._number(values[_MOTION_X_MM10], 1)
        self._number(values[_MOTION_Y_MM10], 1)
        self._number(values[_MOTION_HEADING_CDEG], 2)
        self._number(values[_MOTION_WAY_MM10], 1)
        self._number(values[_MOTION_TURN_CDEG], 2)
        self._number(values[_MOTION_ODOMETRY_AGE_US] // 100, 1)

    def _status(self, values):
        self._number(values[_STATUS_VERSION_MAJOR], 0)
        self._byte(0x2E)
        self._digits(values[_STATUS_VERSION_MINOR], 0)
        self._byte(0x2E)
        self._digits(values[_STATUS_VERSION_PATCH], 0)
        for k in range(_STATUS_UPTIME_S, _STATUS_FIELDS):
            if k == _STATUS_STATE:
                self._byte(0x2C)
                self._byte(_STATES[values[k]])
            elif k == _STATUS_GAIN_CDB:
                self._number(values[k], 2)
            elif k == _STATUS_GREY_MEAN:
                self._number_unless(values[k], m.GREY_UNKNOWN, 0)
            elif k == _STATUS_RATE_CHZ:
                self._number_unless(values[k], m.RATE_UNKNOWN, 2)
            elif _STATUS_FRAME_US <= k <= _STATUS_LATENCY_US:
                self._number_unless(values[k], m.TIME_UNKNOWN, 0)
            else:
                self._number(values[k], 0)

    def _finish(self):
        check = 0
        for k in range(1, self._end):
            check ^= self.buffer[k]
        self._byte(0x2A)
        self._byte(_HEX[check >> 4])
        self._byte(_HEX[check & 15])
        self._byte(13)
        self._byte(10)
        return self._end

    def _byte(self, byte):
        self.buffer[self._end] = byte
        self._end += 1

    def _text(self, text):
        for k in range(len(text)):
            self._byte(text[k])

    def _number_unless(self, value, none, decimals):
        self._number_if(value != none, value, decimals)

    def _number_if(self, known, value, decimals):
        if known:
            self._number(value, decimals)
        else:
            self._byte(0x2C)

    def _number(self, value, decimals):
        """A comma and value / 10**decimals."""
        self._byte(0x2C)
        if value < 0:
            self._byte(0x2D)
            value = -value
        self._digits(value, decimals)

    def _digits(self, value, decimals):
        scale = 1
        places = 1
        while places <= decimals or value // scale >= 10:
            scale *= 10
            places += 1
        while places:
            if places == decimals:
                self._byte(0x2E)
            self._byte(0x30 + value // scale % 10)
            scale //= 10
            places -= 1
