"""Runs `larics ros2`, again when it ends: ros2 launch larics_ros camera.launch.py port:=/dev/ttyACM0"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration

# name, option of `larics ros2`, default ("": not given), meaning
ARGUMENTS = (
    ("port", "--port", "/dev/ttyACM0", "serial port of the camera, or tcp://HOST:PORT"),
    ("baud", "--baud", "115200", "speed of the port"),
    ("domain", "--domain", "", "of DDS; empty: ROS_DOMAIN_ID"),
    ("interface", "--interface", "", "network interface; empty: loopback"),
    ("namespace", "--namespace", "larics", "of the topics"),
    ("map_frame", "--map-frame", "map", "REP 105"),
    ("odom_frame", "--odom-frame", "odom", "REP 105"),
    ("base_frame", "--base-frame", "base_link", "REP 105"),
    ("camera_frame", "--camera-frame", "camera_optical_frame", "REP 103: optical"),
    ("tf", "--tf", "", "base, odom, tree or none; empty: odom where the camera is sent odometry, else base"),
    ("tf_ahead", "--tf-ahead", "0.0", "seconds by which map -> odom is told for later"),
    ("map", "--map", "", "file with the map; empty: the camera's own"),
    ("settings", "--settings", "", "file with the camera's settings; empty: the camera's own"),
    ("pictures", "--pictures", "", "seconds from one raw frame to the next; empty: none"),
)
# name, option without a value, default, meaning
SWITCHES = (
    ("network", "--network", "false", "use what CYCLONEDDS_URI says, not loopback alone"),
    ("listen", "--listen", "false", "ask the camera nothing"),
)
ALWAYS = ("--reconnect",)


def command(values):
    """The words of the command by the values ({name: text}) of the arguments."""
    words = [values["larics"], "ros2", *ALWAYS]
    for name, option, _, _ in ARGUMENTS:
        if values[name]:
            words += [option, values[name]]
    for name, option, _, _ in SWITCHES:
        if values[name].lower() in ("true", "1", "yes"):
            words.append(option)
    return words


def process(context):
    """The process with the arguments as they are in this launch."""
    names = ["larics", *(entry[0] for entry in ARGUMENTS + SWITCHES)]
    values = {name: LaunchConfiguration(name).perform(context) for name in names}
    return [
        ExecuteProcess(cmd=command(values), name="larics", output="screen", respawn=True, respawn_delay=2.0)
    ]


def generate_launch_description():
    """Called by ros2 launch."""
    declared = [DeclareLaunchArgument("larics", default_value="larics", description="the command")]
    for name, option, default, meaning in ARGUMENTS + SWITCHES:
        told = "%s (%s)" % (meaning, option)
        declared.append(DeclareLaunchArgument(name, default_value=default, description=told))
    return LaunchDescription([*declared, OpaqueFunction(function=process)])
