"""Which serial port is the board's."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from serial.tools import list_ports

from larics.boards import BOARDS
from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics.boards import Board


def known_boards(ports: Iterable[Any]) -> list[tuple[Any, Board]]:
    """(port, Board) of every serial port whose USB id is in the table of boards."""
    by_id = {usb_id: board for board in BOARDS for usb_id in board.usb_ids}
    return [(port, by_id[port.vid, port.pid]) for port in ports if (port.vid, port.pid) in by_id]


def find_port(serial_number: str | None = None, ports: Iterable[Any] | None = None) -> str:
    """The device of the one board that is connected, or of the one with this serial number.

    Raises UserError when there is none, or more than one."""
    found = known_boards(list_ports.comports() if ports is None else ports)
    if serial_number is not None:
        found = [pair for pair in found if pair[0].serial_number == serial_number]
    if len(found) == 1:
        return found[0][0].device
    if not found:
        wanted = " with the serial number %s" % serial_number if serial_number else ""
        raise UserError("no camera board found%s: connect it, or name its port with --port" % wanted)
    listed = ", ".join(
        "%s (%s, serial number %s)" % (port.device, board.name, port.serial_number) for port, board in found
    )
    raise UserError("more than one camera board: %s; choose with --port or --serial" % listed)
