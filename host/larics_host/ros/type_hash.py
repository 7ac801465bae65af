"""RIHS01, ROS 2's hash of a message type: SHA-256 of its description as JSON (REP 2011, REP 2016)."""

from __future__ import annotations

import hashlib
import json

from larics_host.ros.definitions import PRIMITIVES, Struct, referenced, ros_name

# numbers of rosidl's FieldType
_NESTED = 1
_STRING = 17
_ARRAY = 48  # added for a fixed length
_SEQUENCE = 144  # added for any length


def type_hash(name: str, structs: dict[str, Struct]) -> str:
    """ "RIHS01_" and 64 hexadecimal digits, of "package/Name"."""
    others = sorted(referenced(name, structs)[1:], key=ros_name)
    description = {
        "type_description": _description(name, structs),
        "referenced_type_descriptions": [_description(other, structs) for other in others],
    }
    return "RIHS01_" + hashlib.sha256(json.dumps(description).encode()).hexdigest()


def _description(name, structs):
    fields = []
    for field in structs[name].fields:
        nested = field.type if field.type in structs else None
        number = _NESTED if nested else _STRING if field.type == "string" else PRIMITIVES[field.type][2]
        if field.length is not None:
            number += _ARRAY if field.length else _SEQUENCE
        kind = {
            "type_id": number,
            "capacity": field.length or 0,
            "string_capacity": 0,
            "nested_type_name": ros_name(nested) if nested else "",
        }
        fields.append({"name": field.name, "type": kind})
    return {"type_name": ros_name(name), "fields": fields}
