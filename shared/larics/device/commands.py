"""The camera's side of the commands: each is carried out once and answered by ACK or NACK.

A request carries a token. The answers to the last commands that change something are remembered, so
that a retry (same token, same content) gets the same answer and nothing is done twice; the same token
with another content is refused. Commands that only read are simply carried out again.

Only what is asked again soon and by the same requester is a retry: answers are forgotten after a while, and
when the requester's sequence numbers go back, since it has started anew and may draw the same tokens again.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics import settings as setting_rules
from larics.wire import messages as m

# generated: begin indices (tools/make_protocol.py)
_INFO_FIELDS = const(10)
_INFO_BOOT = const(1)
_NACK_REASON = const(2)
_SETTING_FIELDS = const(12)
_SETTING_TOKEN = const(0)
_SETTING_KEY = const(1)
_SETTING_FIRST = const(2)
_SETTING_COUNT = const(3)
_SETTING_VALUE0 = const(4)
_GET_SETTING_KEY = const(1)
_SET_SETTING_KEY = const(1)
_SET_SETTING_FIRST = const(2)
_SET_SETTING_COUNT = const(3)
_SET_SETTING_VALUE0 = const(4)
_GET_RAW_WINDOW = const(1)
_GET_RAW_AGAIN_TRANSFER = const(1)
_GET_RAW_AGAIN_FIRST = const(2)
_GET_RAW_AGAIN_COUNT = const(3)
_RESTART_BOOT = const(1)
# generated: end indices

_TOKEN = const(0)  # index in every command and answer
_REMEMBERED = const(8)
_REMEMBERED_S = const(30)  # longer than any requester retries
_WAITING = const(8)  # answers that may wait to be sent; further requests are dropped, to be retried
_ACKNOWLEDGED = const(0)


class Commands:
    """Gets requests by `on_message` (a Decoder's callback) and is a source of answers for an Outbox.

    settings  a larics.settings.Settings
    raw       a larics.device.raw_frame.RawSender
    boot      a random number of this start, 0..65535
    uptime    a larics.device.outbox.Uptime that somebody advances
    odometry  a larics.locate.odometry.Odometry: takes what the vehicle tells of its wheels
    actions   object with
        info(values)            fills the fields of INFO beside token and boot
        settings_changed(name)  a setting has a new value; False or MemoryError when it does not fit in memory
        settings_restored(name) after that: it has its value of before again; False when nothing is detected
                                any more, because the heap is cut up: then only a restart helps
        save()                  writes the settings; False or OSError when that failed
        raw_frame()             (pixels, width, height, frame number) of a copy that stays unchanged until
                                the next call, or None
        window()                (left, top, columns, rows) around the markers in that frame, None without one

    `restart_due` becomes True when the camera has to restart, as soon as its answer was sent; `unanswered`
    counts the requests that were dropped.
    """

    def __init__(self, settings, raw, actions, boot, uptime, odometry):
        self.values = None
        self.restart_due = False
        self.unanswered = 0
        self._settings = settings
        self._raw = raw
        self._actions = actions
        self._boot = boot
        self._uptime = uptime
        self._odometry = odometry
        self._sequence = -1
        self._remembered = []  # (command, values, reason, detail, uptime in seconds), newest last
        self._waiting = []  # (token, command, reason, detail)
        self._info = [0] * _INFO_FIELDS
        self._info_due = False
        self._part = [0] * _SETTING_FIELDS
        self._reading = None  # (token, key, numbers) of a GET_SETTING under way
        self._read = 0
        self._list_key = -1
        self._list = []

    def announce(self):
        """Sends INFO without being asked: at start."""
        self._info[_TOKEN] = 0
        self._info_due = True

    # requests

    def on_message(self, number, sequence, values):
        if number == m.ODOMETRY:  # a hundred a second
            if sequence - self._sequence == 1:
                self._sequence = sequence
            else:
                self._watch_requester(sequence)
            self._odometry.take(values)
            return
        if number < m.FIRST_COMMAND:
            return
        self._watch_requester(sequence)
        if len(self._waiting) >= _WAITING:
            self.unanswered = (self.unanswered + 1) & m.COUNT_MAX
            return
        token = values[_TOKEN]
        if number in (m.PING, m.GET_INFO, m.GET_SETTING):
            self._answer(token, number, self._look_up(number, values), 0)
            return
        content = list(values)
        for command, known, reason, detail, _ in self._remembered:
            if known[_TOKEN] == token:
                if command != number or known != content:
                    self._answer(token, number, m.NACK_TOKEN, 0)
                    return
                if command == m.GET_RAW and reason == _ACKNOWLEDGED and self._raw.token == token:
                    self._raw.repeat_header()
                self._answer(token, number, reason, detail)
                return
        reason = self._carry_out(number, values)
        detail = values[_SET_SETTING_KEY] if number == m.SET_SETTING and reason else 0
        if len(self._remembered) >= _REMEMBERED:
            self._remembered.pop(0)
        self._remembered.append((number, content, reason, detail, self._uptime.s))
        self._answer(token, number, reason, detail)

    def _watch_requester(self, sequence):
        if self._sequence >= 0 and (sequence - self._sequence) & 0xFFFF > 0x7FFF:
            self._remembered.clear()
            self._list, self._list_key = [], -1
        self._sequence = sequence
        while self._remembered and self._uptime.s - self._remembered[0][4] > _REMEMBERED_S:
            self._remembered.pop(0)

    def _answer(self, token, command, reason, detail):
        if reason >= 0:
            self._waiting.append((token, command, reason, detail))

    def _look_up(self, number, values):
        """The reason to refuse, 0, or -1 when the answer follows the data."""
        if number == m.GET_INFO:
            self._info[_TOKEN] = values[_TOKEN]
            self._info_due = True
        elif number == m.GET_SETTING:
            field = setting_rules.field(values[_GET_SETTING_KEY])
            if field is None:
                return m.NACK_UNKNOWN_KEY
            numbers = field.numbers(getattr(self._settings, field.name))
            self._reading = (values[_TOKEN], field.key, numbers)
            self._read = 0
            return -1
        return _ACKNOWLEDGED

    def _carry_out(self, number, values):
        if number == m.SET_SETTING:
            return self._set(values)
        if number == m.SAVE_SETTINGS:
            try:
                return _ACKNOWLEDGED if self._actions.save() is not False else m.NACK_STORAGE
            except OSError:
                return m.NACK_STORAGE
        if number == m.GET_RAW:
            frame = self._actions.raw_frame()
            if frame is None:
                return m.NACK_NO_FRAME
            window = self._actions.window() if values[_GET_RAW_WINDOW] == m.RAW_MARKERS else None
            self._raw.start(values[_TOKEN], *frame, window)
            return _ACKNOWLEDGED
        if number == m.GET_RAW_AGAIN:
            first, count = values[_GET_RAW_AGAIN_FIRST], values[_GET_RAW_AGAIN_COUNT]
            if values[_GET_RAW_AGAIN_TRANSFER] != self._raw.token:
                return m.NACK_TRANSFER
            if count > self._raw.size - first:
                return m.NACK_PIXELS
            return _ACKNOWLEDGED if self._raw.again(first, count) else m.NACK_BUSY
        if number == m.RESTART:
            if values[_RESTART_BOOT] != self._boot:
                return m.NACK_BOOT
            self.restart_due = True
            return _ACKNOWLEDGED
        return m.NACK_UNKNOWN_COMMAND

    def _set(self, values):
        key, first, count = values[_SET_SETTING_KEY], values[_SET_SETTING_FIRST], values[_SET_SETTING_COUNT]
        field = setting_rules.field(key)
        if field is None:
            return m.NACK_UNKNOWN_KEY
        if count > field.most_numbers() or first > count:
            return m.NACK_LENGTH
        if first == 0:
            self._list_key = key
            self._list = []
        elif key != self._list_key or first != len(self._list):
            return m.NACK_LIST_ORDER
        end = _SET_SETTING_VALUE0 + min(count - first, m.SETTING_VALUES)
        self._list.extend(values[_SET_SETTING_VALUE0:end])
        if len(self._list) < count:
            return _ACKNOWLEDGED
        numbers, self._list, self._list_key = self._list, [], -1
        value = field.value(numbers)
        if value is None:
            return m.NACK_LENGTH
        if field.reason(value):
            return m.NACK_RANGE
        name, settings = field.name, self._settings
        before = getattr(settings, name)
        try:
            settings.set(name, value)
            if self._actions.settings_changed(name) is not False:
                return _ACKNOWLEDGED
        except ValueError:
            return m.NACK_CONFLICT
        except MemoryError:
            pass
        setattr(settings, name, before)  # it was valid with the others, and set() needs memory
        if self._actions.settings_restored(name) is False:
            self.restart_due = True
        return m.NACK_MEMORY

    # answers

    def busy(self):
        return bool(self._info_due or self._reading or self._waiting)

    def next(self):
        """The type of the next message to send, its fields in `values`; 0 when there is none."""
        if self._info_due:
            self._info_due = False
            self._info[_INFO_BOOT] = self._boot
            self._actions.info(self._info)
            self.values = self._info
            return m.INFO
        if self._reading:
            return self._next_part()
        if not self._waiting:
            return 0
        self.values = self._waiting.pop(0)
        return m.NACK if self.values[_NACK_REASON] else m.ACK

    def _next_part(self):
        token, key, numbers = self._reading
        part = self._part
        part[_SETTING_TOKEN] = token
        part[_SETTING_KEY] = key
        part[_SETTING_FIRST] = self._read
        part[_SETTING_COUNT] = len(numbers)
        for k in range(m.SETTING_VALUES):
            index = self._read + k
            part[_SETTING_VALUE0 + k] = numbers[index] if index < len(numbers) else 0
        self._read += m.SETTING_VALUES
        if self._read >= len(numbers):
            self._reading = None
            self._waiting.append((token, m.GET_SETTING, _ACKNOWLEDGED, 0))
        self.values = part
        return m.SETTING
