"""`larics flash` on a stand-in board: the real interpreter behind a raw REPL on a pseudo-terminal, with a
real FAT file system as its flash, which survives a loss of power."""

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
import serial
from mpremote.romfs import VfsRomWriter

import larics
from larics.boards import BOARDS, find
from larics_host import cli, sources
from larics_host.commands import flash as flash_command
from larics_host.connection.pty_pair import PtyPair
from larics_host.connection.serial_ports import Identity
from larics_host.errors import UserError
from larics_host.flash import build, install, ports
from larics_host.flash.session import Session, SessionError
from tests.host.test_dual import ROOT, unix_port
from tests.host.waiting import PATIENCE_S
from tools import make_package

RT1062 = "OMVRT1060 32768 SDRAM"

# a program of the same form as the real one, small enough to be flashed often
START = """
import time
import larics
from larics import part
def main():
    for _ in range(12):
        print("larics %s runs on OpenMV RT1062, " % larics.__version__ + part.NAME)
        time.sleep_ms(50)
"""

STUMBLED = b"stumbles on OpenMV RT1062"

# ... that also looks whether this start is the third in a row, as the real one
CAREFUL_START = (
    START.replace("def main():\n", "def main():\n    if is_third():\n        return\n")
    + """
def is_third():
    import os
    import safe_mode
    try:
        os.mkdir("/flash/larics_data")
    except OSError:
        pass
    return safe_mode.SafeMode("/flash/larics_data/starts").begin()
"""
)


class Board:
    """A stand-in board at the end of a cable; `port` is its device, `image` its flash."""

    def __init__(self, cable, image, identity=RT1062, options=()):
        self.port = cable.device_b
        self.image = image
        command = [sys.executable, str(ROOT / "tests/host/board_console.py"), cable.device_a, str(image)]
        self._console = subprocess.Popen(
            [*command, identity, *unix_port(), *options],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def _order(self, word):
        self._console.stdin.write(word + "\n")
        self._console.stdin.flush()
        return self._console.stdout.readline().strip()

    def power_on(self):
        """Returns what the line carries before anything that the board says from now on."""
        return self._order("on").encode()

    def power_off(self):
        self._order("off")

    def close(self):
        self._console.stdin.close()
        self._console.wait(timeout=PATIENCE_S)
        self._console.stdout.close()

    def boots(self):
        """Restarts the board; what it says from then on until a program has given its name."""
        with serial.Serial(self.port, 115200, timeout=0.1) as console:
            power_on = self.power_on()
            data, end_s = b"", time.monotonic() + PATIENCE_S
            while not re.search(rb"RT1062, \w+\s", data.partition(power_on)[2]) and time.monotonic() < end_s:
                data += console.read(512)
        return data.partition(power_on)[2].decode("utf-8", "replace")


@pytest.fixture
def board(tmp_path):
    with PtyPair() as cable:
        made = Board(cable, tmp_path / "flash.img")
        made.power_on()
        yield made
        made.close()


def tiny_program(tmp_path, name, start=START):
    """A folder like the repository's with a program that says its name."""
    root = tmp_path / ("program_" + name)
    shutil.rmtree(root, ignore_errors=True)
    (root / "shared" / "larics").mkdir(parents=True)
    (root / "firmware").mkdir()
    shutil.copy(ROOT / "shared" / "larics" / "__init__.py", root / "shared" / "larics")
    (root / "shared" / "larics" / "part.py").write_text("NAME = %r\n" % name)
    (root / "firmware" / "start.py").write_text(start)
    for starter in ("main.py", "boot.py", "safe_mode.py"):
        shutil.copy(ROOT / "firmware" / starter, root / "firmware")
    return root


def flash(board, root, monkeypatch, *options):
    monkeypatch.setattr(sources, "source_root", lambda: root)
    return cli.main(["flash", "--port", board.port, *options])


def tree(board):
    """{path: size} of all that is on the flash."""
    with Session(board.port) as session:
        session.run(
            "import os\n"
            "def _all(p):\n"
            " for e in os.ilistdir(p):\n"
            "  q = p + '/' + e[0]\n"
            "  if e[1] & 0x4000:\n"
            "   yield from _all(q)\n"
            "  else:\n"
            "   yield q, os.stat(q)[6]\n"
        )
        return session.evaluate("dict(_all('/flash'))")


def test_a_small_heap_gets_the_small_build(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    program = tiny_program(tmp_path, "small")
    with PtyPair() as cable:
        made = Board(cable, tmp_path / "flash.img", options=("-X", "heapsize=400k"))
        try:
            made.power_on()
            assert flash(made, program, monkeypatch) == 0
            said = capsys.readouterr().out
            assert "KB: compiling the small-heap build" in said
            (names,) = (tmp_path / "larics" / "programs").iterdir()
            assert "names for larics traceback: %s\n" % names in said
            broken = tiny_program(
                tmp_path,
                "broken",
                "import larics\n\nclass Wheel:\n    pass\n\n\nWheel().turn()\n",
            )
            assert flash(made, broken, monkeypatch) == 2
            assert "AttributeError: 'Wheel' object has no attribute 'turn'" in capsys.readouterr().err
            assert flash(made, program, monkeypatch, "--small-heap", "no", "--dry-run") == 0
            assert "small-heap" not in capsys.readouterr().out
        finally:
            made.close()


@pytest.mark.long(50)
def test_the_real_program_starts_after_it_was_flashed(board, capsys):
    assert cli.main(["flash", "--port", board.port]) == 0
    said = capsys.readouterr().out
    assert "OpenMV RT1062 (%s)" % RT1062 in said and "first installation" in said
    assert said.splitlines()[-1].strip() == "larics %s runs on OpenMV RT1062" % larics.__version__
    # Ctrl-C lets the running watchdog's board restart into safe mode, where the REPL answers
    with Session(board.port) as session:
        assert session.exists("/flash/larics_data") and session.read_text("/flash/larics_a/complete") == "0"


def test_dry_run_install_update_what_is_kept_and_no_safe_mode(board, tmp_path, monkeypatch, capsys):
    first, second = [tiny_program(tmp_path, name, CAREFUL_START) for name in ("one", "two")]
    assert flash(board, first, monkeypatch, "--dry-run") == 0
    assert "nothing was written" in capsys.readouterr().out and tree(board) == {}
    assert flash(board, first, monkeypatch) == 0
    with Session(board.port) as session:
        session.make_folder("/flash/larics_data")
        session.write("/flash/larics_data/settings.json", b'{"baud": 57600}')
        session.write("/flash/larics_data/map.json", b"{}")
    assert "runs on OpenMV RT1062, one" in board.boots()
    assert flash(board, second, monkeypatch) == 0
    said = capsys.readouterr().out
    assert "update" in said and "main.py: unchanged" in said and "calibration: kept" in said
    assert "larics_b as number 1" in said
    assert "runs on OpenMV RT1062, two" in board.boots()
    with Session(board.port) as session:
        assert session.read_text("/flash/larics_data/starts") == "2"
    assert flash(board, first, monkeypatch, "--no-restart") == 0
    files = tree(board)
    assert files["/flash/larics_data/settings.json"] == 15 and "/flash/main.py.new" not in files
    assert sorted(name for name in files if "complete" in name) == [
        "/flash/larics_a/complete",
        "/flash/larics_b/complete",
    ]
    assert "runs on OpenMV RT1062, one" in board.boots()


def plan_of(session, root):
    """What an installation of this program would do."""
    files = build.compile_program(root, build.architecture(session.identity()[2], find(RT1062)))
    starters = [(root / "firmware" / name).read_bytes() for name in ("main.py", "boot.py")]
    return install.Plan(session, files, *starters)


def test_power_lost_at_any_step_leaves_a_board_that_starts(board, tmp_path, monkeypatch):
    first, second = tiny_program(tmp_path, "one"), tiny_program(tmp_path, "two")
    (second / "firmware" / "main.py").write_text((ROOT / "firmware" / "main.py").read_text() + "# newer\n")
    assert flash(board, first, monkeypatch) == 0
    board.power_off()
    good = board.image.read_bytes()
    told, step, without_main = [], 0, 0
    while True:
        board.power_off()
        board.image.write_bytes(good)
        board.power_on()
        finished, has_main = interrupted_install(board, second, step)
        without_main += not has_main
        board.power_off()
        said = board.boots()
        assert "runs on OpenMV RT1062, " in said, (step, said)
        told.append(said.split("OpenMV RT1062, ")[1][:3])
        if finished:
            break
        step += 1
    assert without_main == 1  # between its removal and the renaming of the new one: boot.py does the rest
    assert step > 8 and told[0] == "one" and told[-1] == "two"
    assert told == sorted(told)  # never back
    board.power_off()
    board.image.write_bytes(good)
    board.power_on()
    interrupted_install(board, second, 4)
    board.power_off()
    board.power_on()
    assert flash(board, second, monkeypatch) == 0  # the next attempt succeeds
    assert "two" in board.boots()


def interrupted_install(board, root, steps):
    """Installs until `steps` changes were made, in the middle of the next. (Whether it was not cut off,
    whether there is a main.py)."""
    left = [steps]

    def counted(method):
        def call(*arguments):
            left[0] -= 1
            if left[0] < 0:
                if method.__name__ == "write":  # half of the file
                    method(arguments[0], arguments[1][: len(arguments[1]) // 2])
                raise SessionError("power lost")
            return method(*arguments)

        return call

    with Session(board.port) as session:
        plan = plan_of(session, root)
        for name in ("remove_tree", "make_folder", "write", "rename"):
            setattr(session, name, counted(getattr(session, name)))
        try:
            install.install(session, plan, lambda *_: None)
            finished = True
        except SessionError:
            finished = False
        return finished, session.exists("/flash/main.py")


def with_rom(board, content=b"", size=65536):
    """Restarts the board with a ROMFS partition of that content."""
    board.power_off()
    file = board.image.with_name(board.image.name + ".rom")
    file.write_bytes(content + b"\xff" * (size - len(content)))
    board.power_on()
    return file


def test_romfs_takes_the_program_and_what_was_before_is_the_way_back(board, tmp_path, monkeypatch, capsys):
    one, two = tiny_program(tmp_path, "one"), tiny_program(tmp_path, "two")
    assert flash(board, one, monkeypatch) == 0
    before = tree(board)
    assert flash(board, two, monkeypatch, "--romfs") == 2
    assert "no ROMFS partition: flash it without --romfs" in capsys.readouterr().err
    model = VfsRomWriter()
    model.mkfile("model.tflite", b"weights")
    with_rom(board, bytes(model.finalise()))
    assert flash(board, two, monkeypatch, "--romfs") == 2
    assert "holds other files (model.tflite)" in capsys.readouterr().err
    with_rom(board, size=64)
    assert flash(board, two, monkeypatch, "--romfs") == 2
    assert "ROMFS has 0 KB, " in capsys.readouterr().err and tree(board) == before

    file = with_rom(board)
    assert flash(board, two, monkeypatch, "--romfs") == 0
    said = capsys.readouterr().out
    assert "into /rom as number 1" in said and tree(board).keys() == before.keys()
    assert "two" in board.boots()
    image = file.read_bytes()
    with_rom(board, image[:300])  # as when the power fails
    assert "one" in board.boots()
    assert flash(board, two, monkeypatch, "--romfs") == 0
    assert file.read_bytes() == image
    assert flash(board, tiny_program(tmp_path, "six"), monkeypatch) == 0  # newer than that in ROMFS
    assert "six" in board.boots()


def test_only_what_is_known_is_said_of_a_start_that_failed(board, tmp_path, monkeypatch, capsys):
    read_until = flash_command._read_until
    monkeypatch.setattr(  # as if the time were over when it has stumbled
        flash_command,
        "_read_until",
        lambda link, port, device, wanted, limit_s: read_until(link, port, device, STUMBLED, PATIENCE_S),
    )
    root = tiny_program(tmp_path, "one")
    (root / "firmware" / "start.py").write_text(START.replace("larics %s runs on", "%s stumbles on"))
    assert flash(board, root, monkeypatch) == 2
    err = capsys.readouterr().err
    assert "it says: " in err and "stumbles on" in err and err.count("\n") == 1
    assert "whether it runs is not known, there was no program on it before" in err


@pytest.mark.parametrize(
    "text, back, part",
    [
        (
            "",
            False,
            "A1) has not come back within 30 s: whether the new program runs is not known",
        ),
        ("", True, "it says nothing; whether it runs is not known, the program before is still on its flash"),
        (
            "boot\r\nMPY: soft reboot\r\n",
            True,
            "it says: boot / MPY: soft reboot; whether it runs is not known",
        ),
        (
            "the program in /flash/larics_b cannot be loaded\r\nTraceback:\r\nImportError: no x\r\nruns",
            True,
            "the board cannot load the new program: ImportError: no x; the one before runs",
        ),
    ],
)
def test_what_is_told_of_a_board_that_did_not_report_its_program(text, back, part):
    plan = SimpleNamespace(is_update=True, folder="/flash/larics_b")
    device = Identity(0x37C5, 0x1206, "A1")
    failed = "the program in %s cannot be loaded" % plan.folder
    told = flash_command._why_not_started(text, back, "/dev/ttyACM0", device, "runs", failed, plan)
    assert part in told


def test_somebody_elses_boot_file_is_kept(board, tmp_path, monkeypatch):
    first, second = tiny_program(tmp_path, "one"), tiny_program(tmp_path, "two")
    with Session(board.port) as session:
        session.write("/flash/boot.py", b"print('mine')\n")
    assert flash(board, first, monkeypatch, "--no-restart") == 0
    with Session(board.port) as session:
        assert session.read_text("/flash/boot.py") == "print('mine')\n"
        session.write("/flash/boot.py", (ROOT / "firmware" / "boot.py").read_bytes()[:50])  # cut off
    (second / "firmware" / "main.py").write_text((ROOT / "firmware" / "main.py").read_text() + "# newer\n")
    assert flash(board, second, monkeypatch, "--no-restart") == 0
    with Session(board.port) as session:
        assert session.read_text("/flash/boot.py") == (ROOT / "firmware" / "boot.py").read_text()


def test_a_program_that_cannot_be_loaded_gives_way_to_the_one_before(board, tmp_path, monkeypatch, capsys):
    good, bad = tiny_program(tmp_path, "one"), tiny_program(tmp_path, "bad")
    (bad / "shared" / "larics" / "part.py").write_text("import nothing_of_that_name\n")
    assert flash(board, good, monkeypatch) == 0
    monkeypatch.setattr("larics_host.commands.flash._BANNER_S", 3)
    flash(board, bad, monkeypatch)
    said = board.boots()
    assert "larics_b cannot be loaded" in said and "runs on OpenMV RT1062, one" in said


def test_a_file_that_reads_back_differently_is_noticed(board):
    with Session(board.port) as session:
        session.run(
            "import hashlib\n"
            "class _Wrong:\n"
            " def update(self, d): pass\n"
            " def digest(self): return bytes(32)\n"
            "import sys\n"
            "class _Module: pass\n"
            "sys.modules['hashlib'] = _Module\n"
            "_Module.sha256 = _Wrong\n"
        )
        with pytest.raises(SessionError, match="reads back differently"):
            session.write("/flash/x", b"data")


def test_a_full_flash_is_told_before_anything_is_written(board, tmp_path, monkeypatch, capsys):
    with Session(board.port) as session:
        session.run("f = open('/flash/big', 'wb')\nfor _ in range(4050): f.write(bytes(512))\nf.close()")
    assert flash(board, tiny_program(tmp_path, "one"), monkeypatch) == 2
    err = capsys.readouterr().err
    assert "KB free" in err and len(err.splitlines()) == 1 and len(tree(board)) == 1


def test_an_sd_card_that_would_win_is_told(board, tmp_path, monkeypatch, capsys):
    real = Session.exists
    monkeypatch.setattr(Session, "exists", lambda self, path: path == "/sdcard/main.py" or real(self, path))
    assert flash(board, tiny_program(tmp_path, "one"), monkeypatch, "--dry-run") == 0
    assert "the SD card has a main.py" in capsys.readouterr().err


def test_a_board_that_is_not_in_the_table_is_refused(tmp_path, capsys):
    with PtyPair() as cable:
        other = Board(cable, tmp_path / "flash.img", "Pyboard v1.1")
        other.power_on()
        assert cli.main(["flash", "--port", other.port]) == 2
        other.close()
    err = capsys.readouterr().err
    assert "is a Pyboard v1.1, not one of OpenMV N6" in err and len(err.splitlines()) == 1


def test_a_board_without_uname_says_what_it_is_all_the_same(board):
    with Session(board.port) as session:
        session.run("import sys\nclass Bare: pass\nsys.modules['omv'] = sys.modules['os'] = Bare")
        assert session.identity()[0].startswith("linux")


def test_a_port_without_a_board(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("larics_host.flash.session._RECONNECT_S", 1)
    monkeypatch.setattr(Session, "__enter__", lambda self: self.open(1))
    assert cli.main(["flash", "--port", "/dev/no-such-port"]) == 2
    assert "no port /dev/no-such-port" in capsys.readouterr().err
    (tmp_path / "note.txt").write_text("hello")
    for name in (str(tmp_path / "note.txt"), str(tmp_path), "/dev/null"):
        assert cli.main(["flash", "--port", name]) == 2
        assert "%s is no serial port" % name in capsys.readouterr().err
    with PtyPair() as cable:
        assert cli.main(["flash", "--port", cable.device_b]) == 2
    err = capsys.readouterr().err
    assert "does not answer" in err and len(err.splitlines()) == 1


def usb_port(device, usb_id, number):
    return SimpleNamespace(device=device, vid=usb_id[0], pid=usb_id[1], serial_number=number)


def test_the_port_is_found_by_its_usb_id_and_refused_when_ambiguous():
    n6, rt = BOARDS[0].usb_ids[0], BOARDS[1].usb_ids[0]
    other = usb_port("/dev/ttyUSB0", (0x0403, 0x6001), "FT1")
    two = [other, usb_port("/dev/ttyACM0", n6, "A1"), usb_port("/dev/ttyACM1", rt, "B2")]
    assert ports.find_port(ports=two[:2]) == "/dev/ttyACM0"
    assert ports.find_port("B2", ports=two) == "/dev/ttyACM1"
    with pytest.raises(UserError, match="more than one camera board: /dev/ttyACM0 .OpenMV N6, serial"):
        ports.find_port(ports=two)
    with pytest.raises(UserError, match="no camera board found"):
        ports.find_port(ports=[other])
    with pytest.raises(UserError, match="serial number C3"):
        ports.find_port("C3", ports=two)


def mpy(arch, version=6, sub_version=3):
    return build.ARCHITECTURES.index(arch) << 10 | sub_version << 8 | version


def test_architecture_and_mpy_version():
    n6, esp = BOARDS[0], BOARDS[-1]
    assert build.architecture(mpy("armv7emdp"), n6) == "armv7emsp"
    assert build.architecture(mpy("armv7emsp"), n6) == "armv7emsp"
    assert build.architecture(mpy("xtensawin"), esp) == "xtensawin"
    for value, text in ((mpy("armv7emsp", version=5), "version 5"), (6, "does not load native code"),
                        (mpy("armv7emsp", sub_version=2), "6.3")):  # fmt: skip
        with pytest.raises(UserError, match=text):
            build.architecture(value, n6)


def test_the_program_has_what_a_board_needs_and_nothing_else():
    names = [name for _, name in build.program(ROOT)]
    assert {"start.mpy", "larics/detect/detector.mpy", "cameras/openmv_csi.mpy"} < set(names)
    assert not {"main.mpy", "pc/replay_main.mpy", "larics/_cpython.mpy"} & set(names)
    assert names.index("larics/wire/codec.mpy") < names.index("start.mpy")  # libraries first
    for march in ("armv7emsp", "xtensawin"):
        assert all(data[:1] == b"M" for _, data in build.compile_program(ROOT, march))


def test_package_json_is_that_of_its_generator_and_mip_installs_it(board, tmp_path):
    assert make_package.TARGET.read_text() == make_package.package(), "run: python tools/make_package.py"
    package = json.loads(make_package.TARGET.read_text())
    assert all((ROOT / source).is_file() for _, source in package["urls"])
    wanted = ("larics/__init__.py", "larics/boards.py", "faults.py")
    few = [pair for pair in package["urls"] if pair[0] in wanted]
    assert len(few) == 3
    (tmp_path / "package.json").write_text(json.dumps(dict(package, urls=few)))
    for folder in ("shared", "firmware"):
        os.symlink(ROOT / folder, tmp_path / folder)
    mpremote = [sys.executable, "-m", "mpremote", "connect", board.port, "mip", "install", "--target"]
    result = subprocess.run(
        [*mpremote, "/flash/lib", str(tmp_path / "package.json")],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    with Session(board.port) as session:
        for name, source in few:
            data = (ROOT / source).read_bytes()
            found = session._link.fs_hashfile("/flash/lib/" + name, "sha256")
            assert bytes(found) == hashlib.sha256(data).digest()
