"""Types of ROS 2 and their bytes, against rosbags and mcap-ros2-support as independent readers."""

import math
import random
import struct

import pytest
from mcap_ros2._dynamic import generate_dynamic
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from larics.wire import codec as protocol
from larics_host.connection.receiver import message_of
from larics_host.connection.records import as_json
from larics_host.errors import UserError
from larics_host.ros.cdr import decode, encode
from larics_host.ros.definitions import (
    PRIMITIVES,
    STRUCTS,
    definition_text,
    parse_definition,
    referenced,
    ros_name,
)
from larics_host.ros.topics import Names
from larics_host.ros.type_hash import type_hash
from larics_host.ros.wire_types import from_ros, name_of, to_ros, type_of, wire_structs

PUBLISHED = (
    "geometry_msgs/PoseWithCovarianceStamped",
    "tf2_msgs/TFMessage",
    "diagnostic_msgs/DiagnosticArray",
    "visualization_msgs/MarkerArray",
    "sensor_msgs/CompressedImage",
    "foxglove_msgs/ImageAnnotations",
)
WIRE = [type_of(name) for name, *_ in protocol.MESSAGES]


def store(which=Stores.ROS2_JAZZY):
    """A typestore of rosbags that knows foxglove_msgs and larics_msgs by the definitions that bags carry."""
    types = get_typestore(which)
    for name in ["foxglove_msgs/ImageAnnotations", *WIRE]:
        found = get_types_from_msg(definition_text(name, wire_structs()), ros_name(name))
        types.register({key: value for key, value in found.items() if key not in types.types})
    return types


@pytest.fixture(scope="module")
def jazzy():
    return store()


@pytest.mark.parametrize("which", [Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_LYRICAL])
def test_the_table_is_that_of_ros(which):
    types = get_typestore(which)
    for name in STRUCTS:
        if not name.startswith("foxglove_msgs"):
            assert type_hash(name, STRUCTS) == types.hash_rihs01(ros_name(name)), name
            if which != Stores.ROS2_HUMBLE or "Marker" not in name:  # which lacks the constant ARROW_STRIP
                assert (
                    definition_text(name, STRUCTS) == types.generate_msgdef(ros_name(name), ros_version=2)[0]
                )


def test_hashes_of_other_packages_are_those_of_their_definitions(jazzy):
    for name in ["foxglove_msgs/ImageAnnotations", *WIRE]:
        assert type_hash(name, wire_structs()) == jazzy.hash_rihs01(ros_name(name))
    # as ros-jazzy-foxglove-msgs has it
    assert type_hash("foxglove_msgs/ImageAnnotations", STRUCTS).startswith("RIHS01_bc4e578b1ef80953415d6f96")


def drawn(name, structs, draw):
    """A random message, some of its fields left out."""
    value = {}
    for field in structs[name].fields:
        if draw.random() < 0.1:
            continue
        count = draw.randrange(4) if field.length == 0 else field.length
        items = [drawn_one(field.type, structs, draw) for _ in range(1 if count is None else count)]
        value[field.name] = items[0] if count is None else items
    return value


def drawn_one(kind, structs, draw):
    if kind in structs:
        return drawn(kind, structs, draw)
    if kind == "string":
        return "".join(draw.choice("abc éß漢") for _ in range(draw.randrange(6)))
    if kind == "bool":
        return draw.random() < 0.5
    if kind.startswith("float"):
        return struct.unpack("<f", struct.pack("<f", draw.uniform(-1e6, 1e6)))[0]
    size = 8 * PRIMITIVES[kind][0]
    return (
        draw.randrange(-(2 ** (size - 1)), 2 ** (size - 1))
        if kind.startswith("int")
        else draw.randrange(2**size)
    )


@pytest.mark.parametrize("name", [*PUBLISHED, *WIRE])
def test_bytes_are_those_of_other_implementations(name, jazzy):
    structs, draw = wire_structs(), random.Random(name)
    theirs = generate_dynamic(ros_name(name), definition_text(name, structs))[ros_name(name)]
    for _ in range(25):
        value = drawn(name, structs, draw)
        data = encode(name, value, structs)
        assert bytes(jazzy.serialize_cdr(jazzy.deserialize_cdr(data, ros_name(name)), ros_name(name))) == data
        assert same(decode(name, data, structs), theirs(data), value)


def same(ours, theirs, given):
    """Whether two readers found what was given, or nothing where nothing was."""
    for key, value in ours.items():
        other = getattr(theirs, key)
        if isinstance(value, dict):
            assert same(value, other, given.get(key, {}))
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            assert len(value) == len(other)
            assert all(same(*three) for three in zip(value, other, given[key], strict=True))
        else:
            wanted = given.get(key)
            if isinstance(value, (bytes, list)):
                assert list(value) == list(other) == list(wanted or [0.0] * len(value))
            else:
                assert value == other == (wanted or type(value)())
    return True


def test_what_is_no_message_is_refused():
    with pytest.raises(KeyError, match="no field w"):
        encode("geometry_msgs/Point", {"x": 1.0, "w": 2.0}, STRUCTS)
    with pytest.raises(ValueError, match="36 values, not 2"):
        encode("geometry_msgs/PoseWithCovariance", {"covariance": [0.0, 1.0]}, STRUCTS)
    data = encode("diagnostic_msgs/KeyValue", {"key": "abc", "value": "d"}, STRUCTS)
    for size in range(len(data)):
        with pytest.raises((ValueError, struct.error)):
            decode("diagnostic_msgs/KeyValue", data[:size], STRUCTS)
    with pytest.raises(ValueError, match="little-endian"):
        decode("diagnostic_msgs/KeyValue", b"\0\0" + data[2:], STRUCTS)
    with pytest.raises(ValueError, match="longer than the message"):
        decode("tf2_msgs/TFMessage", data[:4] + b"\xff\xff\xff\xff", STRUCTS)


def test_a_definition_is_read_back():
    for name in [*PUBLISHED, *WIRE]:
        structs = parse_definition(name, definition_text(name, wire_structs()))
        assert set(structs) == set(referenced(name, wire_structs()))
        assert all(structs[one].fields == wire_structs()[one].fields for one in structs)


def test_every_message_of_the_wire_comes_back_with_its_unknowns():
    draw = random.Random(5)
    for name, number, _, fields in protocol.MESSAGES:
        for _ in range(20):
            values = []
            for field, code, _, low, high, _ in fields:
                if code.endswith("s"):
                    size = int(code[:-1])
                    data = b"desk" if field == "board" else draw.randbytes(size)
                    values.append(data.ljust(size, b"\0"))
                else:
                    values.append(draw.choice([low, high, draw.randint(low, high)]))
            message = message_of(number, draw.randrange(65536), values, 1.25)
            kind = type_of(name)
            assert name_of(ros_name(kind)) == name
            data = encode(kind, to_ros(message, {"sec": 1}), wire_structs())
            value = decode(kind, data, wire_structs())
            told = as_json(message.fields)
            assert from_ros(name, value) == {
                **told, "message": name, "sequence": message.sequence, "time_s": 1.25
            }  # fmt: skip
            for field, one in told.items():
                if one is None:  # nobody takes it for a measure
                    assert (
                        value[field] == -1 if field in ("id", "route_position") else math.isnan(value[field])
                    )
    assert name_of("geometry_msgs/msg/Pose") is None


@pytest.mark.parametrize(
    "names, part",
    [
        ({"namespace": "2nd"}, "namespace '2nd'"),
        ({"namespace": "a//b"}, "namespace 'a//b'"),
        ({"namespace": ""}, "namespace ''"),
        ({"map": "/map"}, "frame '/map'"),
        ({"base": "base link"}, "frame 'base link'"),
        ({"odom": "map"}, "must differ"),
    ],
)
def test_names_that_ros_does_not_take(names, part):
    with pytest.raises(UserError, match=part.replace("(", r"\(")):
        Names(**names)
    assert Names("robot_1/camera").topic("pose") == "/robot_1/camera/pose"
