# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Modules that say that they know no ROS, or no rclpy, can be imported where there is none."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.quick_end import QUICK_END

ROOT = Path(__file__).resolve().parents[2]
#: What decides where the robot goes knows no rclpy, whatever it says (docs/architecture.md).
DECIDING = ("cpr_ros.following", "cpr_ros.closed_loop", "cpr_ros.operation.session")

#: Imports the modules it is given, each as if it were the first; tells those that fail, and why.
IMPORT_ALL = """
import importlib, importlib.abc, re, sys
missing = re.compile(sys.argv[1])

class Missing(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if missing.fullmatch(name.partition(".")[0]):
            raise ModuleNotFoundError(f"{name} is missing", name=name)

sys.meta_path.insert(0, Missing())
for name in sys.argv[2:]:
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        print(f"{name}: {error}")
"""
RCLPY = r"rclpy|tf2_ros"
ROS = rf"{RCLPY}|rosidl\w*|\w+_(msgs|srvs|interfaces)"


def what_it_says(file):
    """What a module says of itself and of its classes."""
    nodes = ast.walk(ast.parse(file.read_text()))
    said = [
        ast.get_docstring(node) for node in nodes if isinstance(node, ast.Module | ast.ClassDef)
    ]
    return " ".join(" ".join(filter(None, said)).split())


def saying(word):
    """Modules that say that they know nothing of something."""
    pattern = re.compile(rf"\b(no|without) {word}\b", re.IGNORECASE)
    return {
        ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for package in ("cpr_core", "cpr_ros")
        for file in (ROOT / package).rglob("*.py")
        if pattern.search(what_it_says(file))
    }


def deciding():
    """Modules of what decides where the robot goes."""
    files = (ROOT / "cpr_ros").rglob("*.py")
    names = {".".join(file.relative_to(ROOT).with_suffix("").parts) for file in files}
    return {
        name.removesuffix(".__init__")
        for name in names
        if f"{name}.".startswith(tuple(f"{known}." for known in DECIDING))
    }


def failing(missing, modules):
    """Lines about modules that cannot be imported where these packages are missing."""
    done = subprocess.run(
        [sys.executable, "-c", QUICK_END + IMPORT_ALL, missing, *sorted(modules)],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    return done.stdout.splitlines()


def test_what_says_it_knows_no_ros_needs_none():
    modules = saying("ROS")
    assert len(modules) > 35
    assert failing(ROS, modules) == []


def test_what_says_it_knows_no_rclpy_and_what_decides_where_the_robot_goes_need_none():
    said, needed = saying("rclpy"), deciding()
    assert len(said) > 7 and len(needed) > 25
    assert failing(RCLPY, said | needed) == []


@pytest.mark.parametrize(
    ("missing", "module"), [(RCLPY, "cpr_ros.node"), (ROS, "cpr_ros.following.trajectory_order")]
)
def test_a_module_that_needs_it_is_found(missing, module):
    [found] = failing(missing, [module])
    assert found.startswith(f"{module}: ") and found.endswith(" is missing")
