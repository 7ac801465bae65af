"""Copying a program so that the board starts whatever happens: the new one or the one before.

There are two program folders. The new program goes into the one that is not in use: first its `complete` file
is removed, then all files are written and their hashes compared, and `complete` with a higher number is
written last; main.py starts the whole program with the highest number. main.py itself comes after that, when
it differs, as a new file that is renamed. A FAT file system cannot replace a file in one go: for a moment
there is no main.py, so boot.py, written before, renames the new one when the power fails in that moment.
Somebody else's boot.py is left alone. Settings, map and calibration lie elsewhere and are not touched.

With a board's ROMFS, whose files are read in place and take less of the heap, the program goes there instead;
what lies in the two folders stays, to be started where that in ROMFS cannot be loaded.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics_host.flash.session import Session

FOLDERS = ("larics_a", "larics_b")
ROM = "/rom"
DATA_FOLDER = "larics_data"
_SPARE_BYTES = 16384


class Plan:
    """What is to be done on a board: `root` ("/flash/"), `folder` to fill, `number` to give it, the program's
    `files` [(name, bytes)], `loader` (bytes of main.py), `rescue` (of boot.py) and whether each has to be
    written."""

    def __init__(
        self,
        session: Session,
        files: Sequence[tuple[str, bytes]],
        loader: bytes,
        rescue: bytes,
        into_rom: bool = False,
    ) -> None:
        self.root = "/flash/" if session.exists("/flash") else "/"
        self.files = files
        self.loader = loader
        self.rescue = rescue
        numbers = [_number(session.read_text(self.root + name + "/complete")) for name in FOLDERS]
        newest = max(*numbers, _number(session.read_text(ROM + "/complete")))
        self.folder = self.root + FOLDERS[0 if numbers[0] < numbers[1] or newest < 0 else 1]
        self.into_rom = into_rom
        if into_rom:
            self.folder = ROM
        self.number = newest + 1
        self.is_update = newest >= 0
        self.writes_loader = session.read_text(self.root + "main.py") != loader.decode()
        boot, wanted = session.read_text(self.root + "boot.py"), rescue.decode()
        self.writes_rescue = self.writes_loader and boot != wanted and _is_ours(boot, wanted)
        self.has_data = session.exists(self.root + DATA_FOLDER)
        self.sd_card = session.exists("/sdcard/main.py") and not session.exists(self.root + "SKIPSD")
        self.free_bytes = session.free_bytes(self.root.rstrip("/") or "/")

    def size(self) -> int:
        """Bytes to be written."""
        return sum(len(data) for _, data in self.files) + self.starter_bytes()

    def starter_bytes(self) -> int:
        """Bytes of main.py and boot.py, as far as they are written."""
        return len(self.loader) * self.writes_loader + len(self.rescue) * self.writes_rescue

    def check_space(self, session: Session) -> None:
        """Raises UserError when it will not fit, the folder's old content being removed."""
        if self.into_rom:
            _check_rom(session, len(self.rom_image()), {name.split("/")[0] for name, _ in self.files})
            return
        old = _tree_bytes(session, self.folder)
        need = self.size() + 64 * len(self.files) + _SPARE_BYTES
        if self.free_bytes + old < need:
            raise UserError(
                "the board's flash has %d KB free, %d KB are needed: delete files on it"
                % ((self.free_bytes + old) // 1024, need // 1024)
            )

    def rom_image(self) -> bytes:
        """The program as a file system that is read in place."""
        # `complete` last: a part of it is no program
        return rom_image([*self.files, ("complete", str(self.number).encode())])

    def version_hash(self) -> str:
        """Names this program: the beginning of the hash of all its files."""
        digest = hashlib.sha256()
        for name, data in self.files:
            digest.update(name.encode() + b"\0" + data)
        return digest.hexdigest()[:12]


def _is_ours(text, rescue):
    """Whether a boot.py (text, None without one) is from here: whole, of another version, or cut off."""
    return text is None or rescue.startswith(text) or text.startswith(rescue.splitlines()[0])


def rom_image(files: Sequence[tuple[str, bytes]]) -> bytes:
    """Files [(name, bytes)] as a ROMFS, in their order."""
    from mpremote.romfs import VfsRomWriter

    writer = VfsRomWriter()
    _put(writer, [(name.split("/"), data) for name, data in files])
    return bytes(writer.finalise())


def _put(writer, files):
    """Files as (parts of the path, data), those of a folder together."""
    for first in dict.fromkeys(parts[0] for parts, _ in files):
        inside = [(parts[1:], data) for parts, data in files if parts[0] == first]
        if inside[0][0]:
            writer.opendir(first)
            _put(writer, inside)
            writer.closedir()
        else:
            writer.mkfile(first, inside[0][1])


def _check_rom(session, need, ours):
    """Raises UserError where there is no ROMFS, where it is too small or holds somebody else's files."""
    size = session.rom_bytes()
    if not size:
        raise UserError("the board has no ROMFS partition: flash it without --romfs")
    if need > size:
        raise UserError(
            "the board's ROMFS has %d KB, %d KB are needed: flash it without --romfs"
            % (size // 1024, need // 1024)
        )
    names = session.names(ROM)
    others = set() if "complete" in names else set(names) - ours  # a part of ours was not finished
    if others:
        raise UserError(
            "the board's ROMFS holds other files (%s), which would be lost: flash it without --romfs, or "
            "empty it before (mpremote romfs deploy of an empty folder)" % ", ".join(sorted(others)[:4])
        )


def _number(text):
    try:
        return int(text)
    except (TypeError, ValueError):
        return -1


def _tree_bytes(session, path):
    session.run(
        "def _bytes(p):\n"
        " try:\n"
        "  return sum(_bytes(p + '/' + e[0]) if e[1] & 0x4000 else os.stat(p + '/' + e[0])[6] "
        "for e in os.ilistdir(p))\n"
        " except OSError:\n"
        "  return 0"
    )
    return session.evaluate("_bytes(%r)" % path)


def install(session: Session, plan: Plan, progress: Callable[[int, int, str], object]) -> None:
    """Carries a plan out; `progress(bytes done, bytes in all, name)`. SessionError when the board fails."""
    total, done = plan.size(), 0
    if plan.into_rom:
        progress(0, total, "ROMFS")
        session.deploy_rom(plan.rom_image())
        done = total - plan.starter_bytes()
    else:
        done = _write_folder(session, plan, progress, total)
    if plan.writes_loader:
        progress(done, total, "main.py")
        session.write(plan.root + "main.py.new", plan.loader)
        if plan.writes_rescue:
            session.write(plan.root + "boot.py", plan.rescue)
        session.remove_tree(plan.root + "main.py")
        session.rename(plan.root + "main.py.new", plan.root + "main.py")
        done = total
    progress(done, total, "done")


def _write_folder(session, plan, progress, total):
    """Writes the program's folder; returns the number of bytes."""
    done = 0
    session.remove_tree(plan.folder + "/complete")  # from here on it is not whole
    session.remove_tree(plan.folder)
    session.make_folder(plan.folder)
    folders = set()
    for name, data in plan.files:
        parts = name.split("/")[:-1]
        for depth in range(1, len(parts) + 1):
            folder = plan.folder + "/" + "/".join(parts[:depth])
            if folder not in folders:
                folders.add(folder)
                session.make_folder(folder)
        progress(done, total, name)
        session.write(plan.folder + "/" + name, data)
        done += len(data)
    session.write(plan.folder + "/complete", str(plan.number).encode())
    return done
