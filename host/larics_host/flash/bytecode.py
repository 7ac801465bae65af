"""Rewrites MicroPython's bytecode so that a compiled file has each of its names once.

Once names are shared (flash.short_names), many of a file's names are the same text. Here what refers to them
refers to the first, the table of names is as long as there are different ones, and the most used ones come
first: their numbers take one byte instead of two, wherever they stand. What a class says of its name goes.

The format is that of MicroPython's py/bc0.h and py/bc.h for .mpy version 6.3.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from larics_host.flash.mpy_file import Code, MpyFile

_NAME, _NUMBER, _JUMP = 1, 2, 3  # what follows opcodes of each sixteen
_FOLLOWED_BY = (0, _NAME, _NUMBER, _NUMBER, _JUMP)
_NO_MORE_BYTE = 0x9E  # opcodes with one of these bits are not followed by a further byte
_SIGNED = (0x40, 0x42, 0x43, 0x44)  # jumps that may go back: out of a loop, always, if true, if false
_SHORT, _LONG = 64, 16384  # how far these go back in one byte and in two


@dataclass
class _Instruction:
    """What an opcode at a place of the old code is followed by.

    name    the number of a name, and target the place that a jump goes to, where `kind` says so
    size    bytes of either
    stays   what comes after that, or all
    """

    place: int
    opcode: int
    kind: int
    name: int = 0
    stays: bytes = b""
    target: int = 0
    size: int = 0


def share_names(file: MpyFile, has_lines: bool) -> None:
    """Each name of a file once. Files with machine code stay as they are: they have few names.

    has_lines: the code tells its lines by counting its bytes, so that their number has to stay."""
    codes = list(_all(file.code))
    if any(not code.is_bytecode for code in codes):
        return
    functions = [_Function(code.data, has_lines) for code in codes]
    if not has_lines:
        for function in functions:
            function.forget_class(file.names)
    first, *others = file.names
    if not has_lines:
        used = Counter(file.names[number] for function in functions for number in function.names())
        others = [name for name, _ in used.most_common() if name != first]
    names = list(dict.fromkeys([first, *others]))
    numbers = {name: number for number, name in enumerate(names)}
    for code, function in zip(codes, functions, strict=True):
        code.data = function.written([numbers.get(name, 0) for name in file.names])
    file.names = names


def _all(code: Code) -> Iterator[Code]:
    yield code
    for child in code.children:
        yield from _all(child)


class _Function:
    """The bytecode of one function."""

    def __init__(self, data: bytes, keeps_size: bool) -> None:
        self._data = data
        self._keeps_size = keeps_size
        self._at = 0
        arguments = self._signature()
        self._head = data[: self._at]
        info, self._cells = self._sizes()
        end = self._at + info
        self._called = [self._number() for _ in range(1 + arguments)]  # its name and those of its arguments
        self._lines = data[self._at : end]
        first = end + self._cells
        self._closed = data[end:first]
        self._at = first
        self._instructions: list[_Instruction] = []
        while self._at < len(data):
            self._instructions.append(self._instruction())
        self._end = self._at

    def forget_class(self, names: Sequence[str]) -> None:
        """Takes out what a class first says of itself, module and whole name, which nobody asks for."""
        told = [names[one.name] if one.kind == _NAME else "" for one in self._instructions[:4]]
        if told[:2] == ["__name__", "__module__"] and told[3:] == ["__qualname__"]:
            del self._instructions[:4]

    def names(self) -> Iterator[int]:
        yield from self._called
        yield from (one.name for one in self._instructions if one.kind == _NAME)

    def written(self, numbers: Sequence[int]) -> bytes:
        """The bytecode with `numbers` of names in the place of those it has."""
        called = b"".join(_number(numbers[number]) for number in self._called)
        head = self._head + _sizes(len(called) + len(self._lines), self._cells)
        return head + called + self._lines + self._closed + self._code(numbers)

    def _code(self, numbers):
        instructions = self._instructions
        for one in instructions:
            if one.kind == _NAME:
                one.size = one.size if self._keeps_size else len(_number(numbers[one.name]))
            elif one.kind == _JUMP and not self._keeps_size:
                one.size = 1
        while True:
            places, at = {}, 0
            for one in instructions:
                places[one.place] = at
                at += 1 + one.size + len(one.stays)
            places[self._end] = at
            far = [one for one in instructions if one.kind == _JUMP and not _is_near(one, places)]
            if not far:
                break
            for one in far:
                one.size = 2
        found = bytearray()
        for one in instructions:
            found.append(one.opcode)
            if one.kind == _NAME:
                found += _number(numbers[one.name], one.size)
            elif one.kind == _JUMP:
                found += _distance(one, places)
            found += one.stays
        return bytes(found)

    def _byte(self) -> int:
        self._at += 1
        return self._data[self._at - 1]

    def _number(self) -> int:
        value = 0
        while True:
            byte = self._byte()
            value = value << 7 | byte & 127
            if byte < 128:
                return value

    def _signature(self) -> int:
        """How many arguments have names."""
        byte = self._byte()
        count, keywords, turn = byte & 3, 0, 0
        while byte & 128:
            byte = self._byte()
            count |= (byte & 4) << turn
            keywords |= (byte >> 3 & 1) << turn
            turn += 1
        return count + keywords

    def _sizes(self) -> tuple[int, int]:
        """Bytes of names and lines, and number of variables that inner functions see."""
        info = cells = turn = 0
        while True:
            byte = self._byte()
            cells |= (byte & 1) << turn
            info |= (byte >> 1 & 63) << 6 * turn
            turn += 1
            if byte < 128:
                return info, cells

    def _instruction(self) -> _Instruction:
        place = self._at
        opcode = self._byte()
        kind = _FOLLOWED_BY[opcode >> 4] if opcode >> 4 < len(_FOLLOWED_BY) else 0
        made = _Instruction(place, opcode, kind)
        first = self._at
        if kind == _NAME:
            made.name = self._number()
            made.size = self._at - first
            first = self._at
        elif kind == _NUMBER:
            self._number()
        elif kind == _JUMP:
            low = self._byte()
            distance = low if low < 128 else low & 127 | self._byte() << 7
            made.size = self._at - first
            if opcode in _SIGNED:
                distance -= _SHORT if made.size == 1 else _LONG
            made.target = self._at + distance
            first = self._at
        if not opcode & _NO_MORE_BYTE:
            self._byte()
        made.stays = self._data[first : self._at]
        return made


def _way(jump: _Instruction, places: Mapping[int, int]) -> int:
    """How far a jump goes, as its code says it."""
    way = places[jump.target] - places[jump.place] - 1 - jump.size
    return way + (_SHORT if jump.size == 1 else _LONG) if jump.opcode in _SIGNED else way


def _is_near(jump: _Instruction, places: Mapping[int, int]) -> bool:
    return jump.size == 2 or 0 <= _way(jump, places) < 128


def _distance(jump: _Instruction, places: Mapping[int, int]) -> bytes:
    way = _way(jump, places)
    return bytes([way]) if jump.size == 1 else bytes([way & 127 | 128, way >> 7])


def _sizes(info: int, cells: int) -> bytes:
    data = bytearray()
    while True:
        byte = cells & 1 | (info & 63) << 1
        cells >>= 1
        info >>= 6
        if not (cells or info):
            data.append(byte)
            return bytes(data)
        data.append(byte | 128)


def _number(value: int, size: int = 1) -> bytes:
    """In at least so many bytes."""
    data = bytes([value & 127])
    while value > 127 or len(data) < size:
        value >>= 7
        data = bytes([value & 127 | 128]) + data
    return data
