# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Start cpr_node, and rviz if wanted: ros2 launch cpr_ros cpr.launch.py robot:=six_rfs rviz:=true."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode, Node


def node_of(context):
    """The node, with the parameter file of its robot if there is one."""
    robot = LaunchConfiguration("robot").perform(context)
    given = LaunchConfiguration("parameters").perform(context)
    shipped = Path(get_package_share_directory("cpr_ros"), "config", "node", f"{robot}.yaml")
    files = [given] if given else [str(shipped)] if shipped.is_file() else []
    return [
        LifecycleNode(
            package="cpr_ros",
            executable="cpr_node",
            name="cpr_node",
            namespace=LaunchConfiguration("namespace"),
            parameters=[*files, {"robot": robot}],  # the node activates itself
            output="screen",
        )
    ]


def generate_launch_description():
    """Describe what to start."""
    view = str(Path(get_package_share_directory("cpr_ros"), "rviz", "cpr.rviz"))
    arguments = {
        "robot": ("six_rfs", "shipped robot or path of a YAML description"),
        "namespace": ("", "namespace of the node"),
        "parameters": ("", "parameter file; default: the one of the robot, if it has one"),
        "rviz": ("false", "whether to start rviz"),
    }
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in arguments.items()
            ),
            OpaqueFunction(function=node_of),
            Node(
                package="rviz2",
                executable="rviz2",
                namespace=LaunchConfiguration("namespace"),
                arguments=["--display-config", view],
                condition=IfCondition(LaunchConfiguration("rviz")),
            ),
        ]
    )
