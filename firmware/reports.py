"""Puts what the loop knows into messages and on the link. Reuses its value lists: nothing is allocated."""

import larics
from larics import messages as m
from larics.protocol import Encoder

VERSION = tuple(int(part) for part in larics.__version__.split("."))


def padded(text, size):
    """Text or bytes as exactly `size` bytes, cut or filled with zeros."""
    data = text.encode() if isinstance(text, str) else bytes(text)
    return (data + bytes(size))[:size]


class Reports:
    """`link`: Link; `boot`: random number of this start, 0..65535."""

    def __init__(self, link, boot):
        self._link = link
        self._encoder = Encoder(clamp=True)  # a device reports the nearest value rather than nothing
        self.boot = boot
        self._marker = [0] * 12
        self._answer = [0, 0]
        self._refusal = [0, 0, 0, 0]

    def send(self, number, values):
        """Encodes and stores one message; False when the link dropped it."""
        count = self._encoder.encode(number, values)
        return self._link.send(self._encoder.buffer, count)

    def info(self, token, width, height, settings, board, unique_id):
        names = (padded(board, 16), padded(unique_id, 12))
        return self.send(m.INFO, (token, self.boot) + VERSION + (width, height, settings) + names)

    def marker(self, frame, age_us, index, count, measurement, calibrated):
        """One of the markers of a frame; `measurement` as larics.camera fills it."""
        values = self._marker
        flags = measurement.flags
        values[0] = frame
        values[1] = age_us
        values[3] = measurement.marker_id if measurement.marker_id >= 0 else m.ID_NONE
        values[4] = index
        values[5] = count
        if calibrated:
            values[6] = measurement.offset_x_mm10
            values[7] = measurement.offset_y_mm10
            values[8] = measurement.height_mm10
        else:
            flags |= m.MARKER_NO_OFFSET
            values[6] = values[7] = values[8] = 0
        values[2] = flags
        values[9] = measurement.heading_cdeg
        values[10] = measurement.margin
        values[11] = measurement.radius_q8
        return self.send(m.MARKER, values)

    def no_marker(self, frame, age_us):
        """A frame without a marker is reported too."""
        values = self._marker
        for index in range(4, 12):
            values[index] = 0
        values[0] = frame
        values[1] = age_us
        values[2] = m.MARKER_NONE
        values[3] = m.ID_NONE
        return self.send(m.MARKER, values)

    def ack(self, token, command):
        self._answer[0] = token
        self._answer[1] = command
        return self.send(m.ACK, self._answer)

    def nack(self, token, command, reason, detail=0):
        self._refusal[0] = token
        self._refusal[1] = command
        self._refusal[2] = reason
        self._refusal[3] = detail
        return self.send(m.NACK, self._refusal)
