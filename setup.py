# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Packaging of cpr_ros: read by pip (through pyproject.toml) and by colcon (ament_python)."""

from glob import glob

from setuptools import find_packages, setup


def share(folder: str) -> list[tuple[str, list[str]]]:
    """Where ROS looks for the files of a folder, and the files."""
    files = sorted(glob(f"{folder}/*.*"))
    return [(f"share/cpr_ros/{folder}", files)] if files else []


# What the node imports beyond the library. Under colcon ROS itself gives these.
ROS_WHEELS = [
    "cpr-msgs==0.1.0",  # ./msg_defs
    "ros-rclpy==7.1.6",
    "ros-rmw-fastrtps-cpp==8.4.3",
    "ros-diagnostic-msgs==5.3.6",
    "ros-geometry-msgs==5.3.6",
    "ros-lifecycle-msgs==2.0.3",
    "ros-sensor-msgs==5.3.6",
    "ros-std-msgs==5.3.6",
    "ros-std-srvs==5.3.6",
    "ros-trajectory-msgs==5.3.6",
    "ros-visualization-msgs==5.3.6",
]

setup(
    name="cpr_ros",
    version="0.1.0",
    description="Statics and stability of continuum parallel robots: a library and a ROS 2 node",
    license="Apache-2.0",
    maintainer="cpr_ros maintainers",
    maintainer_email="maintainers@example.org",
    python_requires=">=3.11",
    # The robots in config/ travel inside the library, which so finds them without ROS. In a source
    # tree (editable, symlink install) it looks in config/ beside it.
    packages=[
        *find_packages(include=["cpr_core", "cpr_core.*", "cpr_ros", "cpr_ros.*"]),
        "cpr_core.config",
    ],
    package_dir={"cpr_core.config": "config"},
    package_data={"": ["py.typed", "*.json", "*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/cpr_ros"]),
        ("share/cpr_ros", ["package.xml"]),
        *share("config"),
        *share("config/node"),
        *share("launch"),
        *share("rviz"),
    ],
    install_requires=[
        "numpy",
        "scipy",
        "threadpoolctl",
        "numba>=0.58,<0.69",  # of which private interfaces are used: cpr_core/numba_fence
        "pyyaml",
        "jsonschema",
        "tqdm",
        "matplotlib",
    ],
    extras_require={
        "ros": ROS_WHEELS,
        "maps": ["xarray"],
        # Of viser something private is used: cpr_core/viewing/server.py.
        "view": ["viser>=1.1,<1.2", "rich", "pillow"],
        # Programs of other people to compare with: verification/. MuJoCo 4 has no elasticity plugins.
        "verify": ["exudyn>=1.13,<1.14", "mujoco>=3.3,<4", "pyelastica>=1.0,<1.1"],
        "test": [
            *("pytest", "pytest-xdist", "hypothesis", "xarray", "distributed"),
            *("rosbags", "mcap-ros2-support"),
            *("viser>=1.1,<1.2", "rich", "pillow", "playwright"),
        ],
    },
    entry_points={
        "console_scripts": [
            "cpr = cpr_ros.cpr_command:main",
            "cpr_node = cpr_ros.cpr_node:main",
            "cpr_demo = cpr_ros.cpr_demo:main",
            "cpr_view = cpr_ros.cpr_view:main",
        ],
    },
    zip_safe=False,
)
