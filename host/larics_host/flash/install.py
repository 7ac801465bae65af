"""Copying a program so that the board starts whatever happens: the new one or the one before.

There are two program folders. The new program goes into the one that is not in use: first its `complete` file
is removed, then all files are written and their hashes compared, and `complete` with a higher number is
written last; main.py starts the whole program with the highest number. main.py itself comes after that, when
it differs, as a new file that is renamed. A FAT file system cannot replace a file in one go: for a moment
there is no main.py, so boot.py, written before, renames the new one when the power fails in that moment.
Somebody else's boot.py is left alone. Settings, map and calibration lie elsewhere and are not touched.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics_host.flash.session import Session

FOLDERS = ("larics_a", "larics_b")
DATA_FOLDER = "larics_data"
_SPARE_BYTES = 16384


class Plan:
    """What is to be done on a board: `root` ("/flash/"), `folder` to fill, `number` to give it, the program's
    `files` [(name, bytes)], `loader` (bytes of main.py), `rescue` (of boot.py) and whether each has to be
    written."""

    def __init__(
        self, session: Session, files: Sequence[tuple[str, bytes]], loader: bytes, rescue: bytes
    ) -> None:
        self.root = "/flash/" if session.exists("/flash") else "/"
        self.files = files
        self.loader = loader
        self.rescue = rescue
        numbers = [_number(session.read_text(self.root + name + "/complete")) for name in FOLDERS]
        newest = max(numbers)
        self.folder = self.root + FOLDERS[0 if numbers[0] < numbers[1] or newest < 0 else 1]
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
        return sum(len(data) for _, data in self.files) + self._starter_bytes()

    def _starter_bytes(self):
        return len(self.loader) * self.writes_loader + len(self.rescue) * self.writes_rescue

    def check_space(self, session: Session) -> None:
        """Raises UserError when it will not fit, the folder's old content being removed."""
        old = _tree_bytes(session, self.folder)
        need = self.size() + 64 * len(self.files) + _SPARE_BYTES
        if self.free_bytes + old < need:
            raise UserError(
                "the board's flash has %d KB free, %d KB are needed: delete files on it"
                % ((self.free_bytes + old) // 1024, need // 1024)
            )

    def version_hash(self) -> str:
        """Names this program: the beginning of the hash of all its files."""
        digest = hashlib.sha256()
        for name, data in self.files:
            digest.update(name.encode() + b"\0" + data)
        return digest.hexdigest()[:12]


def _is_ours(text, rescue):
    """Whether a boot.py (text, None without one) is from here: whole, of another version, or cut off."""
    return text is None or rescue.startswith(text) or text.startswith(rescue.splitlines()[0])


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
    if plan.writes_loader:
        progress(done, total, "main.py")
        session.write(plan.root + "main.py.new", plan.loader)
        if plan.writes_rescue:
            session.write(plan.root + "boot.py", plan.rescue)
        session.remove_tree(plan.root + "main.py")
        session.rename(plan.root + "main.py.new", plan.root + "main.py")
        done = total
    progress(done, total, "done")
