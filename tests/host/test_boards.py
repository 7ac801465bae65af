"""The table of boards, and that the README says the same."""

from larics.boards import BOARDS
from tests.host.test_dual import ROOT

TIERS = {1: "first choice", 2: "supported", 3: "experimental"}


def row(board):
    uart = 'UART "%s"' % board.uart if isinstance(board.uart, str) else "UART %d" % board.uart
    camera = {"csi": "`csi` or `sensor`", "esp32": "`camera`"}[board.camera]
    button = {None: "-", "SW": "SW", 0: "BOOT"}[board.button]
    return "| %s | %s | %s | %s | %s | %s | %s | %s |" % (
        board.name, uart, board.tx, board.rx, camera, button, board.heap_kib, TIERS[board.tier],
    )  # fmt: skip


def test_the_readme_has_every_board_as_in_the_table():
    text = (ROOT / "README.md").read_text()
    for board in BOARDS:
        assert row(board) in text, row(board)


def test_the_table_is_consistent():
    ids = [usb_id for board in BOARDS for usb_id in board.usb_ids]
    identities = [text.lower() for board in BOARDS for text in board.identities]
    assert len(set(ids)) == len(ids)
    for text in identities:
        assert sum(text in other for other in identities) == 1  # none is found by another's name
    for board in BOARDS:
        assert len(board.name) <= 16 and board.flash.startswith("/") and board.tier in TIERS
        assert board.arch in ("armv7emsp", "xtensawin") and 0 < board.readout_us < 100000
