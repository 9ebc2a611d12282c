# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Drawings show rods, links and joints where they are."""

import matplotlib as mpl
import numpy as np
import pytest
from helpers.shipped_steps import CHAINS, STEPS
from helpers.yaml_content import shipped_content
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import art3d

from cpr_core import leg_shapes, load_robot, solve_forward, solve_home
from cpr_core.drawing.robot_drawing import draw_equilibrium
from cpr_core.drawing.robot_lines import platform_outline


def drawn(described, step=0.0):
    """An equilibrium a step from home, and its drawing."""
    home = solve_home(load_robot(described))
    found = solve_forward(home.robot, home.motors + step)
    axes = Figure().add_subplot(projection=None if home.robot.planar else "3d")
    draw_equilibrium(axes, found, color="tab:blue", label="home", frame_size=0.05)
    return found, axes


def points_of(line):
    return np.column_stack(getattr(line, "_verts3d", line.get_data()))


@pytest.mark.parametrize("name", CHAINS)
def test_rods_links_and_joints_are_drawn(name):
    home, axes = drawn(name)
    shapes, dimensions = leg_shapes(home, 40), 2 if home.robot.planar else 3
    lines = [line for line in axes.lines if line.get_linestyle() != "None"]
    rods = [points_of(line) for line in lines if line.get_linewidth() == 1.6]
    expected = [
        shape.position[shape.rod == rod] for shape in shapes for rod in range(shape.rod.max() + 1)
    ]
    assert len(rods) == len(expected) == len(home.robot.description.rods)
    for points, of_rod in zip(rods, expected, strict=True):
        np.testing.assert_allclose(points, of_rod[:, :dimensions])
    links = [points_of(line) for line in lines if line.get_color() == "0.35"]
    pieces = [piece for shape in shapes for piece in shape.rigid_pieces]
    assert len(links) == len(pieces) > 0
    for points, piece in zip(links, pieces, strict=True):
        np.testing.assert_allclose(points, piece[:, :dimensions])
    marks = [line for line in axes.lines if line.get_marker() in ("o", "s")]
    joints = [joint for shape in shapes for joint in shape.joints]
    assert len(marks) == len(joints)
    for mark, joint in zip(marks, joints, strict=True):
        np.testing.assert_allclose(points_of(mark)[0], joint.position[:dimensions])
        moved = mpl.colors.same_color(mark.get_markerfacecolor(), "black")
        assert moved == (joint.motor is not None)
        assert (mark.get_marker() == "s") == (joint.kind == "prismatic")


@pytest.mark.parametrize("name", ["four_rfr", "gough_stewart"])
def test_the_platform_is_drawn_around_its_joints(name, monkeypatch):
    """Legs of a planar robot were taken in their order, those of others around the platform origin."""
    content = shipped_content(name)
    content["legs"][1:3] = content["legs"][2:0:-1]
    for leg in content["legs"]:
        leg["tip"]["position"][0] -= 0.3
    content["home"]["platform"]["position"][0] += 0.3
    plates = []

    class Plate(art3d.Poly3DCollection):
        def __init__(self, faces, **given):
            plates.extend(faces)
            super().__init__(faces, **given)

    monkeypatch.setattr(art3d, "Poly3DCollection", Plate)
    found, axes = drawn(content, STEPS[name])
    plates += [points_of(line) for line in axes.lines if line.get_linewidth() == 3.0]
    tips = np.array([shape.position[-1] for shape in leg_shapes(found)])
    expected = tips[platform_outline(found.robot)]
    np.testing.assert_allclose(plates[0], expected[:, : plates[0].shape[1]], atol=1e-9)
    x, y = plates[0].T[:2]
    area = 0.5 * abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    assert area == pytest.approx({"four_rfr": 0.02, "gough_stewart": 0.0198}[name], rel=0.02)


def test_clamped_tips_have_no_mark_and_the_label_is_given_once():
    _, axes = drawn("gough_stewart")
    marks = [line for line in axes.lines if line.get_marker() in ("o", "s")]
    assert [mark.get_marker() for mark in marks] == ["s"] * 6  # the feeds
    assert axes.get_legend_handles_labels()[1] == ["home"]
