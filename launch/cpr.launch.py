# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Start cpr_node, and rviz if wanted: ros2 launch cpr_ros cpr.launch.py robot:=six_rfs rviz:=true.

Every parameter of the node is an argument; what is not given is left to the parameter file.
"""

import tempfile
from pathlib import Path

from ament_index_python.packages import (
    PackageNotFoundError,
    get_package_prefix,
    get_package_share_directory,
)
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
)
from launch.event_handlers import OnProcessExit
from launch.events import matches_action
from launch.events.process import ShutdownProcess
from launch.logging import launch_config
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode, Node

from cpr_ros.settings.launch_choices import ARGUMENTS, LaunchChoices, unknown


def executable(name):
    """Where ROS has it; pip, which knows nothing of that place, puts it into bin."""
    prefix = Path(get_package_prefix("cpr_ros"))
    places = [prefix / "lib" / "cpr_ros" / name, prefix / "bin" / name]
    return str(next((place for place in places if place.exists()), places[0]))


def view(choices, namespace):
    """Rviz. What is missing is said before anything is started that would be left behind."""
    try:
        get_package_prefix("rviz2")
    except PackageNotFoundError:
        raise RuntimeError(
            "rviz:=true, but rviz2 is not installed (apt install ros-$ROS_DISTRO-rviz2): nothing was "
            "started"
        ) from None
    file = choices.view_file()
    if content := choices.view_configuration():
        folder = Path(tempfile.mkdtemp(dir=launch_config.log_dir))  # there may be another view
        file = folder / file.name
        file.write_text(content)
    return Node(
        package="rviz2",
        executable="rviz2",
        namespace=namespace,
        arguments=["--display-config", str(file), "--fixed-frame", choices.fixed_frame()],
        remappings=choices.view_remappings(),
        parameters=choices.view_parameters(),
    )


def started(context):
    """The node, which activates itself, and the view, which ends with it."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    share = Path(get_package_share_directory("cpr_ros"))
    choices = LaunchChoices(given, share)
    node = LifecycleNode(
        executable=executable("cpr_node"),
        name=given["name"],
        namespace=given["namespace"],
        parameters=choices.parameters(),
        output="screen",
    )
    lines = unknown(context.launch_configurations)
    actions = [node]
    if choices.wants_view():
        lines += filter(None, [choices.view_doubt()])
        rviz = view(choices, given["namespace"])
        end = EmitEvent(event=ShutdownProcess(process_matcher=matches_action(rviz)))
        actions += [rviz, RegisterEventHandler(OnProcessExit(target_action=node, on_exit=[end]))]
    return [LogInfo(msg=line) for line in lines] + actions


def generate_launch_description():
    """Describe what to start."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=meaning)
                for name, (default, meaning) in ARGUMENTS.items()
            ),
            OpaqueFunction(function=started),
        ]
    )
