"""The package for ROS workspaces: well formed, and its launch file knows the command that there is."""

import ast
import shutil
import subprocess
import sys
import zipfile
from xml.etree import ElementTree

import pytest
import yaml

from larics.wire import codec as protocol
from larics_host.cli import build_parser
from larics_host.commands import ros2
from larics_host.errors import UserError
from larics_host.ros.dds import LOOPBACK, configuration
from larics_host.ros.topics import Names
from larics_host.ros.type_hash import type_hash
from larics_host.ros.wire_types import wire_structs
from tests.host.test_dual import ROOT
from tools import make_protocol

PACKAGE = ROOT / "ros2" / "larics_ros"
LAUNCH = PACKAGE / "launch"


def launched():
    """What camera.launch.py says without ROS: its tables, and the function that makes the command of them."""
    tree = ast.parse((LAUNCH / "camera.launch.py").read_text())
    wanted = ("ARGUMENTS", "SWITCHES", "ALWAYS", "command")
    found = [
        node
        for node in tree.body
        if getattr(node, "name", None) in wanted
        or (isinstance(node, ast.Assign) and node.targets[0].id in wanted)
    ]
    names = {}
    exec(compile(ast.Module(found, []), "camera.launch.py", "exec"), names)
    return names


def defaults(names):
    return {name: default for name, _, default, _ in names["ARGUMENTS"] + names["SWITCHES"]}


def parsed(words):
    assert words[0] == "larics"
    return build_parser("ros2").parse_args(words[1:])


def test_arguments_are_options_of_the_command_with_its_defaults():
    names = launched()
    args = vars(parsed(names["command"]({"larics": "larics", **defaults(names)})))
    plain = vars(parsed(["larics", "ros2", "--port", "/dev/ttyACM0"]))
    assert args == {**plain, "reconnect": True}
    # every option is an argument, but those that make no sense in a launch
    assert set(args) - set(defaults(names)) == {"run", "reconnect", "input", "speed", "seconds"}


@pytest.mark.parametrize("name", [entry[0] for entry in launched()["ARGUMENTS"]])
def test_every_argument_reaches_its_option(name):
    names = launched()
    value = {"tf": "tree", "baud": "9600", "domain": "7"}.get(name, "12")
    args = parsed(names["command"]({"larics": "larics", **defaults(names), name: value}))
    assert str(getattr(args, name)) in (value, value + ".0")


def test_switches_reach_their_options():
    names = launched()
    for name in ("network", "listen"):
        args = parsed(names["command"]({"larics": "larics", **defaults(names), name: "true"}))
        assert getattr(args, name) is True
    with pytest.raises(UserError):
        parsed(names["command"]({"larics": "larics", **defaults(names), "baud": "fast"}))
    assert ros2.NAME == "ros2"


def test_launch_files_compile_and_include_what_there_is():
    for path in LAUNCH.glob("*.py"):
        tree = ast.parse(path.read_text(), str(path))
        assert any(getattr(node, "name", "") == "generate_launch_description" for node in tree.body)
    text = (LAUNCH / "localization.launch.py").read_text()
    for name in ("launch/camera.launch.py", "config/ekf.yaml"):
        folder, file = name.split("/")
        assert '"%s", "%s"' % (folder, file) in text and (PACKAGE / name).exists()
    assert '"tf": "none"' in text


def test_the_filter_is_fed_with_our_pose_in_our_frames():
    told = yaml.safe_load((PACKAGE / "config" / "ekf.yaml").read_text())["ekf_map"]["ros__parameters"]
    names = Names()
    frames = told["map_frame"], told["odom_frame"], told["base_link_frame"], told["world_frame"]
    assert frames == (names.map, names.odom, names.base, names.map)
    assert told["pose0"] == names.topic("pose")
    # x, y and yaw of the pose; speeds of the wheels
    assert [k for k, used in enumerate(told["pose0_config"]) if used] == [0, 1, 5]
    assert [k for k, used in enumerate(told["odom0_config"]) if used] == [6, 7, 11]
    assert len(told["pose0_config"]) == len(told["odom0_config"]) == 15 and told["two_d_mode"] is True


def plain(element):
    """An element without name spaces and white space."""
    children = [plain(child) for child in element]
    return element.tag.split("}")[-1], dict(element.attrib), (element.text or "").strip(), children


def test_both_sides_look_on_loopback_alike():
    theirs = plain(ElementTree.parse(PACKAGE / "config" / "loopback.xml").getroot())
    ours = plain(ElementTree.fromstring(configuration(None, False)))
    ours[3][0][3][:] = [child for child in ours[3][0][3] if child[0] != "Tracing"]
    assert ours == theirs and "AllowMulticast>false" in LOOPBACK
    assert configuration(None, True) is None and 'name="eth0"' in configuration("eth0", False)


def test_the_package_is_built_with_all_its_files(tmp_path):
    manifest = ElementTree.parse(PACKAGE / "package.xml").getroot()
    assert manifest.get("format") == "3" and manifest.findtext("name") == "larics_ros"
    assert manifest.findtext("export/build_type") == "ament_python"
    shutil.copytree(PACKAGE, tmp_path / "larics_ros", ignore=shutil.ignore_patterns("build", "*.egg-info"))
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q", "wheel", "--no-deps"]
    words = ["--no-build-isolation", "-w", str(tmp_path), str(tmp_path / "larics_ros")]
    subprocess.run([*pip, *words], check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    names = {name.split("/data/", 1)[-1] for name in zipfile.ZipFile(wheel).namelist()}
    share = "share/larics_ros/"
    for path in (*LAUNCH.glob("*.py"), *(PACKAGE / "config").iterdir()):
        assert share + path.parent.name + "/" + path.name in names
    assert {share + "package.xml", "share/ament_index/resource_index/packages/larics_ros"} <= names
    assert manifest.findtext("version") in wheel.name


def test_the_message_files_are_those_of_the_wire_and_of_bags():
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    folder = make_protocol.ROS_MESSAGES
    files = {path.name: path.read_text() for path in folder.iterdir()}
    assert len(files) == len(protocol.MESSAGES)  # what they hold is tested with all that is generated
    types = get_typestore(Stores.ROS2_JAZZY)
    for name, text in files.items():
        kind = "larics_msgs/msg/" + name.removesuffix(".msg")
        types.register(get_types_from_msg(text, kind))
        assert types.hash_rihs01(kind) == type_hash(kind.replace("/msg/", "/"), wire_structs())
    manifest = ElementTree.parse(folder.parent / "package.xml").getroot()
    assert manifest.findtext("name") == "larics_msgs"
    assert manifest.findtext("member_of_group") == "rosidl_interface_packages"
