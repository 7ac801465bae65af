"""Settings in a file that is missing, damaged, of another version or cannot be written: nothing is lost."""

import json
from binascii import crc32

from atomic_file import AtomicFile, unseal
from faults import Faults
from larics.settings import VERSION, Settings
from larics.wire import messages as m
from settings_store import SettingsStore


def sealed(text):
    """The bytes of a whole file with this text."""
    return text.encode() + b"\n#crc %08x\n" % (crc32(text.encode()) & 0xFFFFFFFF)


class Files:
    """Files in memory; full: OSError when written."""

    def __init__(self):
        self.data = {}
        self.full = False
        self.longest = 0  # piece read or written

    def open(self, path, mode):
        if mode == "rb" and path not in self.data:
            raise OSError(2)
        if mode == "wb":
            if self.full:
                raise OSError(28)
            self.data[path] = b""
        return File(self, path)

    def rename(self, source, target):
        self.data[target] = self.data.pop(source)

    def remove(self, path):
        if path not in self.data:
            raise OSError(2)
        del self.data[path]


class File:
    def __init__(self, files, path):
        self.files, self.path, self.at = files, path, 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def read(self, count=1 << 20):
        self.at += count
        self.files.longest = max(self.files.longest, count)
        return self.files.data[self.path][self.at - count : self.at]

    def write(self, data):
        self.files.longest = max(self.files.longest, len(data))
        self.files.data[self.path] += bytes(data)


def kept(files):
    faults = Faults()
    return SettingsStore(AtomicFile("s.json", files, files.open), faults), faults


def test_settings_missing_saved_and_found_again():
    files = Files()
    keeper, faults = kept(files)
    settings = keeper.load()
    assert faults.active == 1 << m.FAULT_SETTINGS_MISSING
    settings.update({"baud": 57600, "map": [[1, 2, 3, 4, 0, 0]], "output": "nmea"})
    assert keeper.save(settings) and faults.active == 0
    keeper, faults = kept(files)
    again = keeper.load()
    assert again.as_dict() == settings.as_dict() and faults.total == 0


def test_settings_are_saved_in_short_pieces():
    files = Files()
    keeper, _ = kept(files)
    settings = Settings({"map": [[k, 0, 20000 * k, 0, 0, 0] for k in range(1, 8)], "route": [1, 2, 3]})
    for _ in range(3):
        assert keeper.save(settings)
    assert files.longest == 256 and len(files.data["s.json"]) > 1500
    assert json.loads(unseal(files.data["s.json"])) == settings.as_dict()


def test_settings_corrupt_from_another_version_and_out_of_range():
    for content, fault, baud in (
        (b"\x00\xff", m.FAULT_SETTINGS_CORRUPT, 115200),
        (sealed("[1, 2"), m.FAULT_SETTINGS_CORRUPT, 115200),
        (sealed("[1, 2]"), m.FAULT_SETTINGS_CORRUPT, 115200),
        (sealed('{"baud": 57600, "width": 5}'), m.FAULT_SETTINGS_CORRUPT, 57600),
        (sealed('{"baud": 57600, "version": %d, "new": 1}' % (VERSION + 1)), m.FAULT_SETTINGS_VERSION, 57600),
    ):
        files = Files()
        files.data["s.json"] = content
        keeper, faults = kept(files)
        assert keeper.load().baud == baud, content
        assert faults.active == 1 << fault and faults.last == fault, (content, faults.last)


def test_power_lost_while_saving_is_told():
    files = Files()
    keeper, _ = kept(files)
    keeper.save(Settings({"baud": 9600}))
    keeper.save(Settings({"baud": 57600}))
    files.data["s.json"] = files.data["s.json"][:-20]
    keeper, faults = kept(files)
    assert keeper.load().baud == 9600 and faults.last == m.FAULT_SAVE_INTERRUPTED and faults.active == 0


def test_a_full_flash_is_told_and_the_old_settings_stay():
    files = Files()
    keeper, faults = kept(files)
    keeper.save(Settings({"baud": 9600}))
    files.full = True
    assert not keeper.save(Settings({"baud": 57600})) and faults.active == 1 << m.FAULT_STORAGE
    assert kept(files)[0].load().baud == 9600
    files.full = False
    assert keeper.save(Settings({"baud": 57600})) and faults.active == 0
