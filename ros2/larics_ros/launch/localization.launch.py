"""The camera with robot_localization: its filter tells map -> odom, and the camera no transform.

ros2 launch larics_ros localization.launch.py port:=/dev/ttyACM0
"""

import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    """Called by ros2 launch."""
    share = get_package_share_directory("larics_ros")
    camera = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(os.path.join(share, "launch", "camera.launch.py")),
        launch_arguments={"port": LaunchConfiguration("port"), "tf": "none"}.items(),
    )
    ekf = Node(
        package="robot_localization",
        executable="ekf_node",
        name="ekf_map",
        output="screen",
        parameters=[LaunchConfiguration("ekf")],
        remappings=[("odometry/filtered", "odometry/map")],
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument("port", default_value="/dev/ttyACM0"),
            DeclareLaunchArgument("ekf", default_value=os.path.join(share, "config", "ekf.yaml")),
            camera,
            ekf,
        ]
    )
