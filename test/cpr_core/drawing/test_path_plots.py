# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures of paths."""

import numpy as np
import pytest
import yaml

from cpr_core import InvalidRequest, find_equilibria, load_robot, solve_home, trace, trace_through
from cpr_core.description.description_file import shipped_robots
from cpr_core.drawing import path_plots
from cpr_core.drawing.map_plots import plot_map
from cpr_core.workspace import map_workspace, pose_grid


def robot_called(name, *motors):
    """The RFRFR robot with other names."""
    content = yaml.safe_load(shipped_robots()["rfrfr"].read_text(encoding="utf-8"))
    content["name"] = name
    for leg, motor in zip(content["legs"], motors, strict=True):
        leg["motor"]["name"] = motor
    return load_robot(content)


def test_a_path_that_was_stopped_is_drawn_up_to_where(monkeypatch, tmp_path):
    """Its curves ended at the last point before: the smallest eigenvalue well above zero at a fold."""
    figures = []
    monkeypatch.setattr(path_plots, "save_figure", lambda figure, _: figures.append(figure))
    found = trace(load_robot("rfrfr"), motors=[50.0, 0.55])
    assert found.stopped.kind == "fold" and found.fractions[-1] < found.stopped.fraction
    path_plots.plot_trace(found, tmp_path / "picture.png")
    motors, eigenvalues = figures[0].axes[2:4]
    assert motors.lines[0].get_xdata()[-1] == found.stopped.fraction
    assert motors.lines[0].get_ydata()[-1] == found.last.motors[0]
    smallest = eigenvalues.lines[0].get_ydata()
    assert abs(smallest[-1]) < 1e-3 * abs(smallest[0])
    assert len(motors.lines[0].get_xdata()) == len(found.equilibria) + 1
    reached = trace(load_robot("rfrfr"), motors=[2.6, 0.56], points=5)
    path_plots.plot_trace(reached, tmp_path / "picture.png")
    np.testing.assert_array_equal(figures[1].axes[2].lines[0].get_xdata(), reached.fractions)


def test_events_of_a_way_past_folds_are_marked_at_their_steps(monkeypatch, tmp_path):
    """There were no marks."""
    figures = []
    monkeypatch.setattr(path_plots, "save_figure", lambda figure, _: figures.append(figure))
    found = trace(load_robot("rfrfr"), motors=[50.0, 0.55], past_folds=True)
    assert len(found.events) > 2
    path_plots.plot_trace(found, tmp_path / "picture.png")
    eigenvalues = figures[0].axes[3]
    markers = [line for line in eigenvalues.lines if line.get_marker() != "None"]
    assert len(markers) == len(found.events)
    steps = [int(line.get_xdata()[0]) for line in markers]
    assert steps == sorted(steps)
    for step, event in zip(steps, found.events, strict=True):
        near = found.fractions[max(0, step - 1) : step + 2]
        assert near.min() - 1e-3 <= event.fraction <= near.max() + 1e-3


def test_a_trace_of_nothing_is_drawn_where_it_was_stopped(tmp_path):
    found = trace_through(load_robot("planar_body"), motors=[[2.0, 0.5, 0.5]])
    assert not found.equilibria
    path_plots.plot_trace(found, tmp_path / "picture.PNG")
    assert (tmp_path / "picture.PNG").read_bytes()[1:4] == b"PNG"


@pytest.mark.parametrize(("name", "lines"), [("rfrfr", 2), ("two_rods", 4)])
def test_one_equilibrium_is_drawn_and_called_what_it_is(name, lines, monkeypatch, tmp_path):
    figures = []
    monkeypatch.setattr(path_plots, "save_figure", lambda figure, _: figures.append(figure))
    home = solve_home(load_robot(name))
    found = find_equilibria(home.robot, home.motors, starts=100)
    unstable = next(entry.equilibrium for entry in found if not entry.stable)
    for equilibrium, state in ((home, "stable"), (unstable, f"index {unstable.index_locked}")):
        path_plots.plot_equilibrium(equilibrium, tmp_path / "picture.png")
        figure = figures.pop()
        assert figure.axes[0].get_title() == f"{name}: {state} with the motors held"
        rods = [line for line in figure.axes[0].lines if len(line.get_xdata()) == 40]
        assert len(rods) == lines


def test_a_picture_of_no_equilibrium_is_refused(tmp_path):
    with pytest.raises(InvalidRequest, match="expected an Equilibrium"):
        path_plots.plot_equilibrium("home", tmp_path / "picture.png")
    with pytest.raises(InvalidRequest, match="at least one equilibrium"):
        path_plots.plot_equilibria([], tmp_path / "picture.png")


def test_names_are_drawn_as_they_are_written(tmp_path):
    """Between two $ they were read as mathematics: no picture, and words about its grammar."""
    robot = robot_called("cost $5_$ robot", "$\\foo$", "right")
    home = solve_home(robot)
    path_plots.plot_trace(trace(robot, motors=home.motors + 0.01, points=3), tmp_path / "path.png")
    found = find_equilibria(robot, home.motors, starts=2)
    path_plots.plot_equilibria(found, tmp_path / "found.png")
    near = {"x": [0.0, 0.01], "y": [0.8, 0.81]}
    mapped = map_workspace(robot, pose_grid(robot, near), workers=0)
    plot_map(mapped, tmp_path / "map.png", field="$\\foo$")
    assert len(list(tmp_path.glob("*.png"))) == 3


def test_numbers_along_axes_are_mathematics_still(tmp_path):
    figure = path_plots.new_figure((4.0, 3.0))
    axes = figure.add_subplot(title="5$ to 7$", xlabel="$", yscale="log", ylim=(0.1, 10.0))
    axes.legend(axes.plot([0.0, 1.0], [0.2, 5.0]), ["$a$"])
    path_plots.save_figure(figure, tmp_path / "picture.png")
    names = (axes.title, axes.xaxis.label, *axes.get_legend().get_texts())
    assert not any(text.get_parse_math() for text in names)
    powers = [label for label in axes.get_yticklabels() if "$" in label.get_text()]
    assert powers and all(label.get_parse_math() for label in powers)


def test_motors_whose_names_begin_with_an_underscore_are_in_the_legend(monkeypatch, tmp_path):
    """Matplotlib leaves such labels out."""
    figures = []
    monkeypatch.setattr(path_plots, "save_figure", lambda figure, _: figures.append(figure))
    robot = robot_called("lefty", "_left", "right")
    found = trace(robot, motors=solve_home(robot).motors + 0.01, points=3)
    path_plots.plot_trace(found, tmp_path / "picture.png")
    motors = figures[0].axes[2]
    legend = motors.get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["_left", "right"]
    colors = [line.get_color() for line in legend.get_lines()]
    assert colors == [line.get_color() for line in motors.lines[:2]]
