"""CDR, the bytes of ROS 2 messages: little-endian, each number aligned to its size (XCDR version 1).

A message is a dict of its fields. What is left out is zero or empty, what the type does not have a KeyError.
"""

from __future__ import annotations

import struct
from typing import Any

from larics_host.ros.definitions import PRIMITIVES, Field, Struct

HEADER = b"\0\1\0\0"  # CDR_LE, no options; alignment counts from behind it


def encode(name: str, value: dict[str, Any], structs: dict[str, Struct]) -> bytes:
    """The bytes of a message of the type "package/Name". struct.error for a number that does not fit."""
    out = bytearray()
    _put_struct(out, name, value, structs)
    return HEADER + bytes(out)


def _align(out, size):
    out.extend(bytes(-len(out) % size))


def _put_struct(out, name, value, structs):
    fields = structs[name].fields
    missing = 0
    for field in fields:
        if field.name in value:
            _put_field(out, field, value[field.name], structs)
        else:
            missing += 1
            _put_field(out, field, _nothing(field, structs), structs)
    if len(fields) - missing != len(value):
        known = {field.name for field in fields}
        raise KeyError("%s has no field %s" % (name, next(key for key in value if key not in known)))


def _nothing(field: Field, structs):
    if field.length is None:
        return {} if field.type in structs else "" if field.type == "string" else 0
    if field.length == 0:
        return ()
    return [{} if field.type in structs else 0] * field.length


def _put_field(out, field, value, structs):
    if field.length is None:
        _put_one(out, field.type, value, structs)
        return
    if field.length == 0:
        _align(out, 4)
        out.extend(struct.pack("<I", len(value)))
    elif len(value) != field.length:
        raise ValueError("%s has %d values, not %d" % (field.name, field.length, len(value)))
    if field.type in PRIMITIVES:
        if len(value):
            size, code, _ = PRIMITIVES[field.type]
            _align(out, size)
            plain = size == 1 and isinstance(value, (bytes, bytearray))
            out.extend(value if plain else struct.pack("<%d%s" % (len(value), code), *value))
        return
    for item in value:
        _put_one(out, field.type, item, structs)


def _put_one(out, kind, value, structs):
    if kind in structs:
        _put_struct(out, kind, value, structs)
    elif kind == "string":
        data = value.encode() + b"\0"
        _align(out, 4)
        out.extend(struct.pack("<I", len(data)))
        out.extend(data)
    else:
        size, code, _ = PRIMITIVES[kind]
        _align(out, size)
        out.extend(struct.pack("<" + code, value))


def decode(name: str, data: bytes, structs: dict[str, Struct]) -> dict[str, Any]:
    """The message in these bytes. ValueError for another encoding, struct.error where they end too early."""
    if data[:2] != HEADER[:2]:
        raise ValueError("the bytes are not little-endian CDR")
    return _Reader(data[len(HEADER) :], structs).take(name)


class _Reader:
    def __init__(self, data, structs):
        self._data = data
        self._at = 0
        self._structs = structs

    def take(self, name):
        return {field.name: self._field(field) for field in self._structs[name].fields}

    def _numbers(self, count, kind):
        size, code, _ = PRIMITIVES[kind]
        self._at += -self._at % size
        form = "<%d%s" % (count, code)
        values = struct.unpack_from(form, self._data, self._at)
        self._at += size * count
        return values

    def _field(self, field):
        if field.length is None:
            return self._one(field.type)
        count = field.length or self._numbers(1, "uint32")[0]
        if count > len(self._data):
            raise ValueError("a sequence is longer than the message")
        if field.type in PRIMITIVES:
            values = self._numbers(count, field.type) if count else ()
            return bytes(values) if field.type in ("uint8", "byte") else list(values)
        return [self._one(field.type) for _ in range(count)]

    def _one(self, kind):
        if kind in self._structs:
            return self.take(kind)
        if kind == "string":
            (size,) = self._numbers(1, "uint32")
            text = self._data[self._at : self._at + size]
            if len(text) != size or not size:
                raise ValueError("a text is longer than the message")
            self._at += size
            return text[:-1].decode()
        return self._numbers(1, kind)[0]
