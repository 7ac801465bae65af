"""The ROS 2 message types that are published, as a table: the interfaces of their packages, frozen.

Common interfaces as of Humble to Lyrical (they are the same in all of them); foxglove_msgs as of
@foxglove/schemas 2.1.0. Tests hold names, order, constants and hashes against `rosbags`.
"""

from __future__ import annotations

from typing import NamedTuple

# size in bytes, code of `struct`, type number in a type description (rosidl's FieldType), of each primitive
PRIMITIVES = {
    "bool": (1, "?", 15),
    "byte": (1, "B", 16),
    "int8": (1, "b", 2),
    "uint8": (1, "B", 3),
    "int16": (2, "h", 4),
    "uint16": (2, "H", 5),
    "int32": (4, "i", 6),
    "uint32": (4, "I", 7),
    "float32": (4, "f", 10),
    "float64": (8, "d", 11),
}

_COMMON = """
builtin_interfaces/Time
 int32 sec
 uint32 nanosec
builtin_interfaces/Duration
 int32 sec
 uint32 nanosec
std_msgs/Header
 builtin_interfaces/Time stamp
 string frame_id
std_msgs/ColorRGBA
 float32 r
 float32 g
 float32 b
 float32 a
geometry_msgs/Point
 float64 x
 float64 y
 float64 z
geometry_msgs/Vector3
 float64 x
 float64 y
 float64 z
geometry_msgs/Quaternion
 float64 x
 float64 y
 float64 z
 float64 w
geometry_msgs/Pose
 geometry_msgs/Point position
 geometry_msgs/Quaternion orientation
geometry_msgs/PoseWithCovariance
 geometry_msgs/Pose pose
 float64[36] covariance
geometry_msgs/PoseWithCovarianceStamped
 std_msgs/Header header
 geometry_msgs/PoseWithCovariance pose
geometry_msgs/Transform
 geometry_msgs/Vector3 translation
 geometry_msgs/Quaternion rotation
geometry_msgs/TransformStamped
 std_msgs/Header header
 string child_frame_id
 geometry_msgs/Transform transform
tf2_msgs/TFMessage
 geometry_msgs/TransformStamped[] transforms
diagnostic_msgs/KeyValue
 string key
 string value
diagnostic_msgs/DiagnosticStatus
 byte OK=0
 byte WARN=1
 byte ERROR=2
 byte STALE=3
 byte level
 string name
 string message
 string hardware_id
 diagnostic_msgs/KeyValue[] values
diagnostic_msgs/DiagnosticArray
 std_msgs/Header header
 diagnostic_msgs/DiagnosticStatus[] status
sensor_msgs/CompressedImage
 std_msgs/Header header
 string format
 uint8[] data
visualization_msgs/UVCoordinate
 float32 u
 float32 v
visualization_msgs/MeshFile
 string filename
 uint8[] data
visualization_msgs/Marker
 int32 ARROW=0
 int32 CUBE=1
 int32 SPHERE=2
 int32 CYLINDER=3
 int32 LINE_STRIP=4
 int32 LINE_LIST=5
 int32 CUBE_LIST=6
 int32 SPHERE_LIST=7
 int32 POINTS=8
 int32 TEXT_VIEW_FACING=9
 int32 MESH_RESOURCE=10
 int32 TRIANGLE_LIST=11
 int32 ARROW_STRIP=12
 int32 ADD=0
 int32 MODIFY=0
 int32 DELETE=2
 int32 DELETEALL=3
 std_msgs/Header header
 string ns
 int32 id
 int32 type
 int32 action
 geometry_msgs/Pose pose
 geometry_msgs/Vector3 scale
 std_msgs/ColorRGBA color
 builtin_interfaces/Duration lifetime
 bool frame_locked
 geometry_msgs/Point[] points
 std_msgs/ColorRGBA[] colors
 string texture_resource
 sensor_msgs/CompressedImage texture
 visualization_msgs/UVCoordinate[] uv_coordinates
 string text
 string mesh_resource
 visualization_msgs/MeshFile mesh_file
 bool mesh_use_embedded_materials
visualization_msgs/MarkerArray
 visualization_msgs/Marker[] markers
foxglove_msgs/Color
 float64 r
 float64 g
 float64 b
 float64 a
foxglove_msgs/Point2
 float64 x
 float64 y
foxglove_msgs/KeyValuePair
 string key
 string value
foxglove_msgs/CircleAnnotation
 builtin_interfaces/Time timestamp
 foxglove_msgs/Point2 position
 float64 diameter
 float64 thickness
 foxglove_msgs/Color fill_color
 foxglove_msgs/Color outline_color
 foxglove_msgs/KeyValuePair[] metadata
foxglove_msgs/PointsAnnotation
 uint8 UNKNOWN=0
 uint8 POINTS=1
 uint8 LINE_LOOP=2
 uint8 LINE_STRIP=3
 uint8 LINE_LIST=4
 builtin_interfaces/Time timestamp
 uint8 type
 foxglove_msgs/Point2[] points
 foxglove_msgs/Color outline_color
 foxglove_msgs/Color[] outline_colors
 foxglove_msgs/Color fill_color
 float64 thickness
 foxglove_msgs/KeyValuePair[] metadata
foxglove_msgs/TextAnnotation
 builtin_interfaces/Time timestamp
 foxglove_msgs/Point2 position
 string text
 float64 font_size
 foxglove_msgs/Color text_color
 foxglove_msgs/Color background_color
 foxglove_msgs/KeyValuePair[] metadata
foxglove_msgs/ImageAnnotations
 builtin_interfaces/Time timestamp
 foxglove_msgs/CircleAnnotation[] circles
 foxglove_msgs/PointsAnnotation[] points
 foxglove_msgs/TextAnnotation[] texts
 foxglove_msgs/KeyValuePair[] metadata
"""
_RULE = "=" * 80


class Field(NamedTuple):
    """A field: its type without brackets, its length (None: a single one, 0: any)."""

    name: str
    type: str
    length: int | None
    comment: str = ""

    def line(self) -> str:
        """As in a .msg file."""
        brackets = "" if self.length is None else "[%s]" % (self.length or "")
        return "%s%s %s" % (self.type, brackets, self.name) + ("  # " + self.comment if self.comment else "")


class Struct(NamedTuple):
    """A message type: the lines of its constants, and its Fields in order."""

    constants: tuple[str, ...]
    fields: tuple[Field, ...]


def parsed(text: str) -> dict[str, Struct]:
    """{"package/Name": Struct} of a text in which the lines of a .msg file, indented, follow each name."""
    structs: dict[str, Struct] = {}
    for line in text.strip().splitlines():
        if not line.startswith(" "):
            name = line.strip()
            structs[name] = Struct((), ())
            continue
        before = structs[name]
        if "=" in line.partition("#")[0]:
            structs[name] = before._replace(constants=(*before.constants, line.strip()))
        else:
            structs[name] = before._replace(fields=(*before.fields, field_of(line)))
    return structs


def field_of(line: str) -> Field:
    """The Field of a line "type name", "type[] name  # comment" or "type[3] name"."""
    content, _, comment = line.partition("#")
    kind, name = content.split()
    base, bracket, count = kind.partition("[")
    return Field(name, base, int(count[:-1] or 0) if bracket else None, comment.strip())


STRUCTS = parsed(_COMMON)


def referenced(name: str, structs: dict[str, Struct]) -> list[str]:
    """The types that a type is made of, itself first, each once, in the order in which they are met."""
    found: list[str] = []

    def walk(one):
        if one in found or one not in structs:
            return
        found.append(one)
        for field in structs[one].fields:
            walk(field.type)

    walk(name)
    return found


def definition_text(name: str, structs: dict[str, Struct]) -> str:
    """The definition of a type with all that it is made of, in the form "ros2msg" of MCAP."""
    parts = []
    for one in referenced(name, structs):
        head = [] if one == name else [_RULE, "MSG: " + one]
        struct = structs[one]
        parts += [*head, *struct.constants, *(field.line() for field in struct.fields)]
    return "\n".join(parts) + "\n"


def parse_definition(name: str, text: str) -> dict[str, Struct]:
    """The inverse of `definition_text`, for texts of others too: all types in it, the first one being `name`.
    ValueError where it is none."""
    table = [name]
    for line in text.splitlines():
        content = line.strip()
        if content.startswith("MSG: "):
            table.append(content[5:])
        elif content and not content.startswith(("#", "=====")):
            table.append(" " + content)
    return parsed("\n".join(table))


def ros_name(name: str) -> str:
    """ "package/msg/Name", as ROS 2 calls "package/Name"."""
    return name.replace("/", "/msg/")
