"""Reads compiled files of MicroPython (.mpy version 6) and puts other machine code in the place of viper's.

The format is that of MicroPython's py/persistentcode.c."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from larics_host.flash.short_names import STATIC

_BYTECODE, _NATIVE, _VIPER = 0, 1, 2  # kinds of code
_FUN_TABLE, _STR, _TUPLE = 0, 5, 10  # kinds of objects
_NO_DATA = range(5)  # of which nothing follows
_RELOCATED, _RODATA, _BSS = 0x10, 0x20, 0x40  # flags of viper's code


@dataclass
class Code:
    """One function's code, or a module's.

    kind     _BYTECODE, _NATIVE or _VIPER
    data     bytecode or machine code
    scope    for _VIPER its flags, for _NATIVE where its description begins
    """

    kind: int
    data: bytes
    scope: int = 0
    children: list[Code] = field(default_factory=list)

    @property
    def is_bytecode(self) -> bool:
        return self.kind == _BYTECODE


class MpyFile:
    """names    the texts it refers to; the first one is the name of its source file
    objects  the kinds of its constant objects
    code     the module's, its functions being children
    """

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 4
        names, count = self._uint(), self._uint()
        self.names = [self._name() for _ in range(names)]
        first = self._at
        self.objects = [self._object() for _ in range(count)]
        self._objects = data[first : self._at]
        self.code = self._code()
        if self._at != len(data):
            raise ValueError("not a compiled file of MicroPython, or of another version")

    @property
    def function_table(self) -> int:
        """Which of the objects is the interpreter's table of functions, that machine code calls."""
        return self.objects.index(_FUN_TABLE) if _FUN_TABLE in self.objects else 0

    def set_machine_code(self, codes: Sequence[bytes]) -> None:
        """Other machine code for a module of viper functions, first to last; for one without, none."""
        kinds = [child.kind for child in self.code.children]
        if kinds != [_VIPER] * len(codes):
            raise ValueError("the module has other functions than %d of viper" % len(codes))
        for child, code in zip(self.code.children, codes, strict=True):
            child.data = code

    def result(self) -> bytes:
        head = self._data[:4] + _number(len(self.names)) + _number(len(self.objects))
        return head + b"".join(map(_written_name, self.names)) + self._objects + _written(self.code)

    def _uint(self) -> int:
        value = 0
        while True:
            byte = self._data[self._at]
            self._at += 1
            value = value << 7 | byte & 127
            if byte < 128:
                return value

    def _name(self) -> str:
        head = self._uint()
        if head & 1:
            return STATIC[(head >> 1) - 1]
        self._at += (head >> 1) + 1
        return self._data[self._at - (head >> 1) - 1 : self._at - 1].decode()

    def _object(self) -> int:
        kind = self._data[self._at]
        self._at += 1
        if kind in _NO_DATA:
            return kind
        length = self._uint()
        if kind == _TUPLE:
            for _ in range(length):
                self._object()
        else:
            self._at += length + (kind in (_STR, _STR + 1))  # text and bytes end with a zero
        return kind

    def _code(self) -> Code:
        head = self._uint()
        kind, size = head & 3, head >> 3
        code = Code(kind, self._data[self._at : self._at + size])
        self._at += size
        if kind != _BYTECODE:
            code.scope = self._uint()
        if kind > _VIPER or (kind == _VIPER and code.scope & (_RELOCATED | _RODATA | _BSS)):
            raise ValueError("machine code of a kind that the program has none of")
        if head & 4:
            code.children = [self._code() for _ in range(self._uint())]
        return code


def _written_name(name: str) -> bytes:
    if name in STATIC:
        return _number(STATIC.index(name) + 1 << 1 | 1)
    data = name.encode()
    return _number(len(data) << 1) + data + b"\0"


def _written(code: Code) -> bytes:
    data = _number(len(code.data) << 3 | bool(code.children) << 2 | code.kind) + code.data
    if code.kind != _BYTECODE:
        data += _number(code.scope)
    if code.children:
        data += _number(len(code.children)) + b"".join(_written(child) for child in code.children)
    return data


def _number(value: int) -> bytes:
    data = bytes([value & 127])
    while value > 127:
        value >>= 7
        data = bytes([value & 127 | 128]) + data
    return data
