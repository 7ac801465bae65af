"""Stand-ins for what MicroPython's compiler provides, so that kernels.py also runs on CPython.

On a board `@micropython.viper`, `ptr8`, `ptr16`, `ptr32` and `const` are syntax of the compiler; this
module is never imported there. On CPython one of three executors runs the very same text, chosen
once at import by the environment variable LARICS_KERNELS:

- ``numba``  compiled; the default when numba is installed
- ``plain``  interpreted, bounds-checked pointers; the default without numba
- ``strict`` interpreted and checked: raises OverflowError where a 32-bit board would wrap, on a
  shift count outside 0..31, and where a negative value is loaded through ptr32 without a mask
  (32-bit boards load it signed, 64-bit ones unsigned); IndexError on any access outside a buffer

Pointers load as viper does (8 and 16 bits unsigned, 32 bits signed) and stores truncate. A buffer's
items must have the pointer's size: bytes, bytearray or memoryview for ptr8, array('H') for ptr16,
array('i') for ptr32.
"""

import os
import types
from array import array
from binascii import crc32

_EXECUTORS = ("numba", "plain", "strict")


def _choose_executor():
    wanted = os.environ.get("LARICS_KERNELS", "")
    if wanted and wanted not in _EXECUTORS:
        raise ImportError("LARICS_KERNELS=%s is unknown; use one of %s" % (wanted, ", ".join(_EXECUTORS)))
    if wanted in ("plain", "strict"):
        return wanted, None
    try:
        import numba
    except ImportError:
        if wanted:
            raise ImportError("LARICS_KERNELS=numba, but numba is not installed: pip install numba")
        return "plain", None
    return "numba", numba


EXECUTOR, _numba = _choose_executor()


def _usable(folder):
    """Whether files can be made in a folder of this user's own; makes it."""
    import tempfile

    try:
        os.makedirs(folder, 0o700, exist_ok=True)
        if hasattr(os, "getuid") and os.stat(folder).st_uid != os.getuid():
            return False  # what somebody else put there would be executed
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def _choose_cache(home, packages, temporary):
    """(folder for compiled loops, None for numba's own choice; whether they can be kept; a line to tell).

    home: the package's folder, where numba keeps them when it can; packages: those beside it whose compiled
    loops, from whoever installed them, are taken along; temporary: where they go at the worst."""
    beside = os.path.join(home, "__pycache__")
    if os.access(home, os.W_OK) and _usable(beside):
        return None, True, None
    own = os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "larics-loops")
    line = None
    folder = own
    if not _usable(own):
        folder = temporary
        if folder and not os.path.isdir(folder):  # else it was told before
            where = (folder, home, own)
            line = "larics: compiled loops are kept in %s, as neither %s nor %s can be written" % where
        if not folder or not _usable(folder):
            return None, False, "larics: no folder can be written: the loops are compiled anew each time"
    _take_along(packages, folder)
    return folder, True, line


def _take_along(packages, folder):
    """Copies what was compiled at the installation: numba reads only where it may write."""
    import hashlib
    import shutil

    for package in packages:
        for directory, _, names in os.walk(package):
            if os.path.basename(directory) != "__pycache__":
                continue
            source = os.path.dirname(directory)
            # as numba names it
            name = "%s_%s" % (os.path.basename(source), hashlib.sha1(source.encode()).hexdigest())
            for file in names:
                target = os.path.join(folder, name, file)
                if file.endswith((".nbi", ".nbc")) and not os.path.exists(target):
                    try:
                        os.makedirs(os.path.dirname(target), exist_ok=True)
                        shutil.copyfile(os.path.join(directory, file), target)
                    except OSError:
                        return


def _keep_compiled():
    """Sees to a folder for compiled loops before any is compiled; False when there is none."""
    if _numba is None or _numba.config.CACHE_DIR:
        return _numba is not None
    import sys
    import tempfile

    home = os.path.dirname(os.path.abspath(__file__))
    try:
        name = "larics-loops-%d" % os.getuid() if hasattr(os, "getuid") else "larics-loops"
        temporary = os.path.join(tempfile.gettempdir(), name)
    except OSError:
        temporary = None
    packages = [home, os.path.join(os.path.dirname(os.path.dirname(home)), "host", "larics_host")]
    packages.append(os.path.join(os.path.dirname(home), "larics_host"))
    folder, kept, line = _choose_cache(home, packages, temporary)
    if folder:
        _numba.config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"] = folder  # processes begun here take it, too
    if line:
        print(line, file=sys.stderr)
    return kept


KEEPS_COMPILED = _keep_compiled()


class _Pointer:
    __slots__ = ("items",)

    def __init__(self, buffer):
        view = memoryview(buffer)
        if view.itemsize != self.size:
            raise TypeError("buffer of %d-byte items given for ptr%d" % (view.itemsize, self.size * 8))
        self.items = view.cast("B").cast(self.code)

    def __getitem__(self, index):
        if index < 0:
            raise IndexError("negative index %d: a board would read before the buffer" % index)
        return self.items[index]

    def __setitem__(self, index, value):
        if index < 0:
            raise IndexError("negative index %d: a board would write before the buffer" % index)
        value = int(value) & self.mask
        if self.code == "i" and value > 0x7FFFFFFF:
            value -= 0x100000000
        self.items[index] = value


class ptr8(_Pointer):
    size, code, mask = 1, "B", 0xFF


class ptr16(_Pointer):
    size, code, mask = 2, "H", 0xFFFF


class ptr32(_Pointer):
    size, code, mask = 4, "i", 0xFFFFFFFF


class _Int32(int):
    """An int whose arithmetic raises where a 32-bit board would wrap."""

    def __neg__(self):
        return _checked(int.__neg__(self))


class _NegativeLoad:
    """A negative value loaded through ptr32: boards differ in its sign, so only a mask is allowed."""

    def __init__(self, value):
        self.value = value

    def __and__(self, mask):
        if not 0 <= mask <= 0x3FFFFFFF:
            raise OverflowError("mask %d of a negative ptr32 load does not fit a small int" % mask)
        return _Int32(self.value & mask)

    def __getattr__(self, name):
        raise OverflowError("negative value %d loaded through ptr32 without a mask" % self.value)

    def _refuse(self, *_):
        raise OverflowError("negative value %d loaded through ptr32 without a mask" % self.value)

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __floordiv__ = __rfloordiv__ = _refuse
    __mod__ = __or__ = __ror__ = __xor__ = __rxor__ = __rshift__ = __lshift__ = __rand__ = _refuse
    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = __ne__ = __neg__ = __index__ = __bool__ = _refuse
    __hash__ = None


def _checked(value):
    if not -0x80000000 <= value <= 0x7FFFFFFF:
        raise OverflowError("%d does not fit int32: a board would wrap" % value)
    return _Int32(value)


def _shift_count(count):
    if not 0 <= count < 32:
        raise OverflowError("shift count %d is outside 0..31" % count)


def _add_checked_operator(name):
    forward, backward = getattr(int, "__%s__" % name), getattr(int, "__r%s__" % name)
    shift = name in ("rshift", "lshift")

    def operator(self, other):
        if isinstance(other, _NegativeLoad):
            other._refuse()
        if shift:
            _shift_count(other)
        return _checked(forward(self, other))

    def reflected(self, other):
        if shift:
            _shift_count(self)
        return _checked(backward(self, other))

    setattr(_Int32, "__%s__" % name, operator)
    setattr(_Int32, "__r%s__" % name, reflected)


for _name in ("add", "sub", "mul", "floordiv", "mod", "and", "or", "xor", "rshift", "lshift"):
    _add_checked_operator(_name)


class _StrictPointer:
    """Wraps a pointer so that what it loads is checked arithmetic from there on."""

    __slots__ = ("pointer",)

    def __init__(self, pointer):
        self.pointer = pointer

    def __getitem__(self, index):
        value = self.pointer[index]
        return _NegativeLoad(value) if value < 0 else _Int32(value)

    def __setitem__(self, index, value):
        self.pointer[index] = value


def _strict_int(value):
    return value if isinstance(value, _NegativeLoad) else _Int32(value)


_POINTERS = (ptr8, ptr16, ptr32)


def _interpreted(function, strict):
    code = function.__code__
    kinds = [function.__annotations__.get(name) for name in code.co_varnames[: code.co_argcount]]
    body = function
    if strict:
        body = types.FunctionType(code, dict(function.__globals__, int=_strict_int), function.__name__)

    def call(*values):
        if len(values) != len(kinds):
            raise TypeError("%s takes %d arguments, not %d" % (function.__name__, len(kinds), len(values)))
        arguments = []
        for value, kind in zip(values, kinds):
            if kind in _POINTERS:
                value = kind(value)
                if strict:
                    value = _StrictPointer(value)
            elif strict:
                value = _checked(value)
            arguments.append(value)
        result = body(*arguments)
        return None if result is None else int(result)

    call.__name__ = function.__name__
    call.__doc__ = function.__doc__
    return call


if EXECUTOR == "numba":
    # int(uint8) stays unsigned in numba and uint64 with int64 becomes a float: every load is wrapped in
    # int() in kernels.py, and that int is this one.
    import numpy as _numpy

    _int64 = _numba.njit(lambda value: _numpy.int64(value))

    def _viper(function):
        body = types.FunctionType(
            function.__code__, dict(function.__globals__, int=_int64), function.__name__
        )
        body.__module__ = function.__module__
        body.__qualname__ = function.__qualname__
        return _numba.njit(cache=KEEPS_COMPILED)(body)
else:

    def _viper(function):
        return _interpreted(function, EXECUTOR == "strict")


class micropython:
    """Stands for MicroPython's module of that name: `@micropython.viper` compiles, `native` leaves as is."""

    viper = staticmethod(_viper)

    @staticmethod
    def native(function):
        return function


try:
    import numpy as np  # with the same lines as ulab's
except ImportError:
    np = None


def const(value):
    return value


def table16(data):
    """A table of 16-bit little-endian items in bytes, as a buffer that ptr16 accepts."""
    return array("H", data)


def frame_view(frame):
    """Any C-contiguous 8-bit buffer as a flat read-only one, of one type, so that numba compiles once.

    Raises ValueError when the items are not single bytes or not contiguous."""
    view = memoryview(frame)
    if view.itemsize != 1 or not view.c_contiguous:
        raise ValueError("a frame is a contiguous buffer of 8-bit pixels")
    if not view.nbytes:
        return b""
    view = view.cast("B", (view.nbytes,)) if view.ndim != 1 else view.cast("B")
    if EXECUTOR != "numba":
        return view
    pixels = _numpy.frombuffer(view, _numpy.uint8)
    pixels.flags.writeable = False
    return pixels


def unstuff(size, left, data, message, state, count, table):
    """What kernels.stream.unstuff does, faster than any kernel where bytes can be searched and copied."""
    size, left = state[1] - 1, state[2] - 1
    data = data if isinstance(data, (bytes, bytearray)) else bytes(data)
    place = state[0]
    end = data.find(0, place, count)
    stop = count if end < 0 else end
    while place < stop:
        if left > 0:
            copied = min(left, stop - place)
            message[size : size + copied] = data[place : place + copied]
            size += copied
            left -= copied
            place += copied
        elif left == 0:
            if size < 0:
                size = 0
            else:
                message[size] = 0
                size += 1
            left = data[place] - 1
            place += 1
            if size + left > 128:  # wire.framing.LIMIT
                left = -1
        else:
            break
    if end < 0:
        state[0], state[1], state[2] = count, size + 1, left + 1
        return 0
    state[0], state[1], state[2] = end + 1, 0, 1
    if size < 0:
        return 2  # nothing
    if left < 0:
        return 3  # over-long
    if left > 0:
        return 4  # ended in the middle of a block
    if size < 8:  # header and CRC
        return 5
    state[3] = size
    if crc32(memoryview(message)[: size - 4]) != int.from_bytes(message[size - 4 : size], "little"):
        return 6
    return 1 if message[0] == 1 else 7  # another version
