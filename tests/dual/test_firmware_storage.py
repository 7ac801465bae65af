"""Kept settings survive a loss of power at every byte written and between any two file operations."""

from binascii import crc32

from atomic_file import CORRUPT, GOOD, MISSING, RESTORED, AtomicFile, unseal


def sealed(text):
    """The bytes of a whole file with this text."""
    return text.encode() + b"\n#crc %08x\n" % (crc32(text.encode()) & 0xFFFFFFFF)


class PowerLoss(Exception):
    pass


class Flash:
    """Files in memory. Every byte written and every rename or removal costs one unit of `energy`; at zero
    the power fails. A full or read-only flash raises OSError."""

    def __init__(self):
        self.files = {}
        self.energy = None
        self.capacity = None
        self.used_energy = 0

    def spend(self):
        if self.energy is not None:
            if not self.energy:
                raise PowerLoss()
            self.energy -= 1
        self.used_energy += 1

    def open(self, path, mode):
        if mode == "wb":
            self.spend()
            self.files[path] = b""
        elif path not in self.files:
            raise OSError(2)
        return File(self, path)

    def rename(self, source, target):
        # FAT: the target is removed first, which is a step of its own
        if source not in self.files:
            raise OSError(2)
        if target in self.files:
            self.remove(target)
        self.spend()
        self.files[target] = self.files.pop(source)

    def remove(self, path):
        if path not in self.files:
            raise OSError(2)
        self.spend()
        del self.files[path]


class File:
    def __init__(self, flash, path):
        self.flash = flash
        self.path = path
        self.at = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def read(self, count=1 << 20):
        self.at += count
        return self.flash.files[self.path][self.at - count : self.at]

    def write(self, data):
        flash = self.flash
        for byte in data:
            if flash.capacity is not None and sum(len(f) for f in flash.files.values()) >= flash.capacity:
                raise OSError(28)
            flash.spend()
            flash.files[self.path] = flash.files[self.path] + bytes([byte])


def store(flash):
    return AtomicFile("settings.json", flash, flash.open)


def saved(*texts):
    flash = Flash()
    for text in texts:
        store(flash).save([text])
    return flash


def test_seal():
    assert unseal(sealed('{"a": 1}')) == '{"a": 1}'
    assert unseal(sealed("")) == ""
    data = sealed("some text")
    for index in range(len(data)):
        assert unseal(data[:index]) is None
        assert unseal(data[:index] + bytes([data[index] ^ 1]) + data[index + 1 :]) is None


def test_a_file_written_by_hand_is_taken_when_it_is_whole():
    text = '{"width": 320, "map": [[1, 2, 3, 4]]}'
    assert unseal(text.encode()) == text and unseal(text.encode() + b"\r\n") == text + "\r\n"
    assert unseal(b"\xef\xbb\xbf" + text.encode()) == text
    data = sealed(text)
    for index in range(len(data)):
        assert unseal(data[:index]) in (None, text, text + "\n"), index
    for index in range(len(text)):
        assert unseal(data[:index]) is None


def test_what_was_saved_is_loaded_and_the_one_before_is_kept():
    flash = Flash()
    assert store(flash).load() == (None, MISSING)
    store(flash).save(["one"])
    assert store(flash).load() == ("one", GOOD)
    store(flash).save(["two"])
    store(flash).save(["th", "", "ree"])
    assert store(flash).load() == ("three", GOOD)
    assert unseal(flash.files["settings.json.old"]) == "two"
    assert "settings.json.new" not in flash.files


def test_loss_of_power_at_every_step_of_a_save():
    before = saved("first", "second")
    complete = saved("first", "second", "the third, longer one")
    steps = complete.used_energy - before.used_energy
    assert steps >= 40
    outcomes = []
    for energy in range(steps):
        flash = saved("first", "second")
        flash.energy = energy
        try:
            store(flash).save(["the third, longer one"])
        except PowerLoss:
            pass
        else:
            raise AssertionError("the power did not fail")
        flash.energy = None
        text, state = store(flash).load()
        assert text in ("second", "the third, longer one"), (energy, text, state)
        outcomes.append(text)
        # and a second loss in the save after that one, at every step again
        for second in range(0, 60):
            again = Flash()
            again.files = dict(flash.files)
            again.energy = second
            try:
                store(again).save(["the fourth"])
            except PowerLoss:
                pass
            again.energy = None
            kept, _ = store(again).load()
            assert kept in (text, "the fourth"), (energy, second, kept)
    assert "second" in outcomes and outcomes[-1] == "the third, longer one"


def test_a_full_flash_keeps_what_was():
    flash = saved("first", "second")
    for room in range(0, 30):
        flash.capacity = sum(len(data) for data in flash.files.values()) + room
        try:
            store(flash).save(["a text that needs more room than there is, by a good deal"])
        except OSError:
            pass
        else:
            raise AssertionError("no error with room for %d bytes" % room)
        assert store(flash).load() == ("second", GOOD)
        assert "settings.json.new" not in flash.files


class Worn(Flash):
    """Takes what is written, and holds something else."""

    def open(self, path, mode):
        file = super().open(path, mode)
        if mode == "rb" and path.endswith(".new"):
            self.files[path] = self.files[path][:-9] + b"0" + self.files[path][-8:]
        return file


def test_what_the_flash_does_not_hold_is_not_taken_into_use():
    flash = Worn()
    flash.files = dict(saved("first", "second").files)
    try:
        store(flash).save(["third"])
        raise AssertionError("no error")
    except OSError:
        pass
    assert store(flash).load() == ("second", GOOD) and "settings.json.new" not in flash.files


def test_a_file_that_is_not_whole_is_not_missing():
    for name in ("settings.json", "settings.json.new", "settings.json.old"):
        flash = Flash()
        flash.files[name] = b"\n#crc"  # shorter than the line of a CRC, too
        assert store(flash).load() == (None, CORRUPT), name


def test_damage_is_found():
    flash = saved("first", "second")
    flash.files["settings.json"] = b"{"
    assert store(flash).load() == ("first", RESTORED)
    flash.files["settings.json.old"] = b"\xff\xfe" * 20
    assert store(flash).load() == (None, CORRUPT)
    store(flash).save(["anew"])
    assert store(flash).load() == ("anew", GOOD)
