"""The start on a board with stand-ins of `machine`, `omv` and `csi`: LEDs, watchdog, safe mode, restarts."""

import os
import sys
import time

sys.path.insert(0, __file__.rsplit("/", 1)[0] + "/fakes")

# the built-in machine module would be found first
sys.modules["machine"] = __import__("fake_machine")

import csi  # noqa: E402
import machine  # noqa: E402
import omv  # noqa: E402
from board_parts import Uart  # noqa: E402

import larics  # noqa: E402
import safe_mode  # noqa: E402
import start  # noqa: E402
from larics import boards  # noqa: E402
from larics.wire import messages as m  # noqa: E402
from wire_values import at  # noqa: E402

FLASH = "build/board_flash"
ACTIVE = at(m.STATUS, "active_faults")


def fresh(arch="OMVRT1060 32768 SDRAM", keep_flash=False):
    """A board that was just powered up."""
    machine.world.__init__()
    csi.world.__init__()
    omv.name = arch
    machine.world.uart = Uart(collect=True)
    for folder in ("build", FLASH):
        try:
            os.mkdir(folder)
        except OSError:
            pass
    larics.boards = sys.modules["larics.boards"] = boards  # the start before has dropped the table
    board = boards.find(arch)
    if board:
        board.flash = FLASH
    if not keep_flash:
        folder = FLASH + "/" + start.FOLDER
        try:
            for name in os.listdir(folder):
                os.remove(folder + "/" + name)
        except OSError:
            pass
    return machine.world


def boot(rounds=30, ending=None):
    """Runs the program for some rounds, then lets `ending` happen; returns what main() did not handle."""
    import loop

    count = [0]
    real = loop.Loop.step

    def step(self):
        csi.world.complete()
        time.sleep_ms(3)  # so that the line, which takes its time, carries something
        count[0] += 1
        if count[0] > rounds:
            raise ending or machine.Reset()
        return real(self)

    loop.Loop.step = step
    try:
        start.main()
    except machine.Reset:
        return "reset"
    finally:
        loop.Loop.step = real
    return "ended"


def statuses():
    return machine.world.uart.of(m.STATUS)


def test_the_program_starts_runs_and_feeds_the_watchdog():
    world = fresh()
    boot(40)
    assert world.watchdog_ms == safe_mode.WATCHDOG_MS and world.fed == 40
    assert world.uart_arguments == (1, 115200)
    info = world.uart.of(m.INFO)[0]
    assert bytes(info[at(m.INFO, "board")]).startswith(b"OpenMV RT1062")
    assert bytes(info[at(m.INFO, "unique_id")])[:6] == machine.unique_id()
    assert len(world.uart.of(m.MARKER)) > 5
    assert statuses()[0][ACTIVE] == 1 << m.FAULT_SETTINGS_MISSING


def test_the_watchdog_is_armed_after_the_set_up():
    world = fresh()
    armed_at = []
    real = start.run

    def run(app, sentinel):
        armed_at.append((world.watchdog_ms, app.parts.sensor.detector is not None, csi.world.opened))
        real(app, sentinel)

    start.run = run
    try:
        boot(3)
    finally:
        start.run = real
    assert armed_at == [(None, True, 1)] and world.watchdog_ms


def test_three_fast_resets_lead_to_safe_mode_and_the_next_start_is_normal():
    fresh()
    assert boot(5) == "reset"
    world = fresh(keep_flash=True)
    assert boot(5) == "reset"
    world = fresh(keep_flash=True)
    assert boot(5) == "ended"
    assert world.watchdog_ms is None and world.resets == 0  # the REPL is free
    assert all(world.lit.values()) and len(world.lit) == 3
    assert statuses()[0][ACTIVE] >> m.FAULT_SAFE_MODE & 1 and len(world.uart.of(m.INFO)) == 1
    world = fresh(keep_flash=True)
    assert boot(5) == "reset" and world.watchdog_ms


def test_starts_that_last_are_not_counted():
    fresh()
    path = FLASH + "/" + start.FOLDER + "/starts"
    boot(1)
    for _ in range(5):
        sentinel = safe_mode.SafeMode(path)
        assert not sentinel.begin()
        sentinel.settled(3)
        sentinel.settled(11)
    assert [safe_mode.SafeMode(path).begin() for _ in range(4)] == [False, False, True, False]


def test_the_button_leads_to_safe_mode():
    world = fresh()
    world.button_held = True
    assert boot(5) == "ended" and world.watchdog_ms is None
    world = fresh("OMV4P H7 32768 SDRAM", keep_flash=True)  # has no button
    world.button_held = True
    assert boot(5) == "reset"


def test_ctrl_c_restarts_into_safe_mode_because_the_watchdog_cannot_be_stopped():
    world = fresh()
    assert boot(5, KeyboardInterrupt()) == "reset" and world.resets == 1
    world = fresh(keep_flash=True)
    assert boot(5) == "ended" and world.watchdog_ms is None


def test_a_board_without_a_watchdog_says_so_and_runs():
    world = fresh()
    kind, told = machine.WDT, []
    del machine.WDT
    start.print = told.append
    try:
        assert boot(5) == "reset" and world.watchdog_ms is None
    finally:
        machine.WDT = kind
        del start.print
    assert len(told) == 1 and "no watchdog" in told[0]


def test_a_reset_by_the_watchdog_is_reported():
    world = fresh()
    world.cause = machine.WDT_RESET
    boot(10)
    assert statuses()[0][ACTIVE] >> m.FAULT_WATCHDOG & 1


def test_an_error_that_nobody_foresaw_restarts_the_board():
    world = fresh()
    assert boot(5, RuntimeError("odd")) == "reset" and world.resets == 1


def test_a_flash_that_cannot_be_written_does_not_prevent_the_start():
    world = fresh()
    board = boards.find(omv.name)
    board.flash = "/proc"
    boot(20)
    assert statuses()[0][ACTIVE] >> m.FAULT_STORAGE & 1 and len(world.uart.of(m.MARKER)) > 3


def test_an_unknown_board_is_named_and_nothing_happens():
    world = fresh("Pyboard v1.1 with STM32F405RG")
    assert boot(5) == "ended" and world.uart_arguments is None


def test_every_board_is_found_by_what_it_says_it_is():
    for text, name in (
        ("OpenMV N6", "OpenMV N6"),
        ("OMVRT1060 32768 SDRAM", "OpenMV RT1062"),
        ("OPENMV AE3", "OpenMV AE3"),
        ("OMV4P H7 32768 SDRAM", "OpenMV H7 Plus"),
        ("NICLAV H7 1024", "Nicla Vision"),
        ("Generic ESP32S3 module with Octal-SPIRAM with ESP32S3", "ESP32-S3"),
    ):
        assert boards.find(text).name == name
    assert boards.find("linux [GCC 14.2.1] version") is None
