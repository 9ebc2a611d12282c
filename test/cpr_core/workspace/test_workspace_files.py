# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Maps on disk: whole at any time, and gone on with after any death."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from helpers.branches import stable_elsewhere
from helpers.workspace_cases import assert_same, rfrfr, six_rfs, small_grid, small_map
from scipy.io import netcdf_file

from cpr_core import InvalidRequest, NoInverseSolution, solve_inverse
from cpr_core.workspace import map_workspace, pose_grid
from cpr_core.workspace.first_cell import without_limits
from cpr_core.workspace.map_files import unfinished_file
from cpr_core.workspace.store import as_dataset, read_map, write_map

CHILD = """
import sys
from cpr_core import load_robot
from cpr_core.workspace import map_workspace, pose_grid

robot = load_robot("rfrfr", modes=5)
grid = pose_grid(robot, {"x": [-0.9, 0.9], "y": [-1.0, 1.0]}, resolution=0.02)
every, *files = sys.argv[1:]
for file in files:
    map_workspace(robot, grid, workers=1, file=file, checkpoint_every=float(every))
"""


@pytest.fixture(scope="module")
def xarray():
    """It takes long to import: not for every worker of the tests."""
    import xarray

    return xarray


def test_a_map_is_read_as_it_was_written(tmp_path):
    file = tmp_path / "map.nc"
    write_map(small_map(), file)
    found = read_map(file, rfrfr())
    assert_same(found, small_map())
    assert found.complete
    np.testing.assert_array_equal(found.usable, small_map().usable)
    assert list(tmp_path.iterdir()) == [file]


def test_a_file_explains_itself(tmp_path, xarray):
    file = tmp_path / "map.nc"
    map_workspace(rfrfr(), small_grid(), file=file)
    with xarray.open_dataset(file, engine="scipy") as dataset:
        assert dataset["index_locked"].dims == ("x", "y")
        assert dataset["x"].attrs["units"] == "m"
        assert dataset["motors"].dims == ("x", "y", "motor")
        assert dataset["motors"].attrs["units"] == "rad"
        assert dataset.attrs["source"] == "cpr_core 0.1.0"
        assert "name: rfrfr" in dataset.attrs["robot_file"]
        assert dataset.attrs["complete"] == 1
        index = dataset["index_locked"].sel(x=0.0, y=0.5, method="nearest")
        assert int(index) == 0
        reached = small_map().reached.reshape(small_grid().shape)
        np.testing.assert_array_equal(dataset["order"].values >= 0, reached)


def test_a_cancelled_map_is_gone_on_with(tmp_path):
    file, calls = tmp_path / "map.nc", []

    def stop():
        calls.append(0)
        return len(calls) > 12

    unfinished = map_workspace(rfrfr(), small_grid(), workers=0, file=file, cancelled=stop)
    assert not unfinished.complete
    assert as_dataset(unfinished).attrs["complete"] == 0
    assert_same(map_workspace(rfrfr(), small_grid(), workers=2, file=file), small_map())
    assert_same(read_map(file, rfrfr()), small_map())


@pytest.mark.slow
def test_a_killed_process_is_gone_on_with(tmp_path, xarray):
    file, whole = tmp_path / "map.nc", tmp_path / "whole.nc"
    rfrfr_map_kernels = small_map()  # compiled and kept on disk before the child loads them
    assert rfrfr_map_kernels.complete
    child = subprocess.Popen([sys.executable, "-c", CHILD, "0.0", str(file)])
    try:
        deadline = time.monotonic() + 300.0
        while time.monotonic() < deadline and child.poll() is None:
            if file.exists() and _expanded(xarray, file) > 500:
                break
            time.sleep(0.01)
        assert child.poll() is None, "the child was done before it could be killed"
    finally:
        child.send_signal(signal.SIGKILL)
        child.wait()
    robot = rfrfr()
    killed = read_map(file, robot)
    assert 500 < killed.expanded < killed.reached.sum()
    assert not killed.complete

    # In a process of its own: kernels this process has just compiled may differ in the last bit.
    subprocess.run([sys.executable, "-c", CHILD, "30.0", str(file), str(whole)], check=True)
    assert_same(read_map(file, robot), read_map(whole, robot))
    with xarray.open_dataset(file) as resumed, xarray.open_dataset(whole) as uninterrupted:
        xarray.testing.assert_identical(resumed, uninterrupted)


def _expanded(xarray, file):
    with xarray.open_dataset(file, engine="scipy") as dataset:
        return int(dataset.attrs["expanded"])


def test_a_complete_map_is_not_made_again(tmp_path):
    file = tmp_path / "map.nc"
    map_workspace(rfrfr(), small_grid(), file=file)
    states = []
    map_workspace(rfrfr(), small_grid(), file=file, progress=states.append)
    assert states == []
    map_workspace(rfrfr(), small_grid(), file=file, resume=False, progress=states.append)
    assert states


def test_a_map_is_gone_on_with_from_each_of_its_cells(tmp_path):
    """Also from those whose straight way to the first cell is blocked."""
    file, options = tmp_path / "map.nc", {"workers": 0, "tolerance": 0.0}
    grid = pose_grid(rfrfr(), {"x": [-1.5, 1.5], "y": [-1.5, 1.5]}, resolution=0.3)
    whole = map_workspace(rfrfr(), grid, file=file, **options)
    first = whole.equilibrium(whole.first)
    blocked = 0
    for cell in np.flatnonzero(whole.reached).tolist():
        start = whole.equilibrium(cell)
        blocked += not leads_straight_to(start, first)
        assert_same(map_workspace(rfrfr(), grid, start=start, file=file, **options), whole)
    assert blocked, "every cell leads straight to the first"


def leads_straight_to(start, end):
    """Whether the straight way from an equilibrium to the pose of another ends at that."""
    free = without_limits(start.robot)
    try:
        found = solve_inverse(free, end.pose, start=replace(start, robot=free))
    except NoInverseSolution:
        return False
    return np.allclose(found.state, end.state, atol=1e-4)


def test_only_maps_are_replaced(tmp_path, xarray):
    """Also maps of other robots and grids; not what only looks like one, nor a map cut short."""
    file = tmp_path / "map.nc"
    write_map(small_map(), file)
    whole = file.read_bytes()
    foreign = xarray.Dataset({"measured": ("time", np.arange(3.0))})
    foreign.to_netcdf(tmp_path / "foreign.nc", engine="scipy")
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(tmp_path / "missing")
    (tmp_path / "text").write_text("precious")
    (tmp_path / "empty").touch()
    (tmp_path / "short").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "magic").write_bytes(b"CDF\x02 of some other program")
    names = sorted(path.name for path in tmp_path.iterdir() if path != file)
    assert len(names) == 7
    for name in names:
        target = tmp_path / name
        before = target.read_bytes() if target.is_file() else None
        with pytest.raises(InvalidRequest, match="is not replaced") as refused:
            map_workspace(rfrfr(), small_grid(), workers=0, file=target, resume=False)
        assert refused.value.argument == "file"
        assert before is None or target.read_bytes() == before
    other = pose_grid(rfrfr(), {"x": [0.0, 0.1], "y": [0.4, 0.5]}, resolution=0.1)
    assert map_workspace(rfrfr(), other, workers=0, file=file, resume=False).complete
    assert read_map(file, rfrfr()).grid.shape == (2, 2)


def test_axes_that_are_called_like_something_of_the_file_are_refused_before_anything_is_mapped(
    tmp_path, xarray
):
    """Motors called row and column, or a free axis called way: the map was lost after the work."""
    with xarray.open_dataset(written_small_map(tmp_path), engine="scipy") as dataset:
        own = {*dataset.variables, *dataset.dims} - {"x", "y"}
    assert len(own) > 30
    robot, file = rfrfr(), tmp_path / "map.nc"
    ranges = {"x": [-0.1, 0.1], "y": [0.4, 0.6]}
    for name in sorted(own):
        axes = {name: ranges["x"], "y": ranges["y"]}
        grid = pose_grid(robot, axes, resolution=0.1, directions={name: {"x": 1.0}})
        with pytest.raises(InvalidRequest, match=f"grid: expected axes with other names.*{name} "):
            map_workspace(robot, grid, file=file)
    assert not file.exists()
    with pytest.raises(InvalidRequest, match="other names"):
        as_dataset(map_workspace(robot, grid, workers=0))


def written_small_map(folder):
    file = folder / "small.nc"
    write_map(small_map(), file)
    return file


@pytest.mark.parametrize("length", [240, 255])
def test_a_map_is_written_to_a_file_of_any_name_there_can_be(tmp_path, length):
    file = tmp_path / f"{'m' * (length - 3)}.nc"
    found = map_workspace(rfrfr(), small_grid(), workers=0, file=file, checkpoint_every=0.0)
    assert_same(read_map(file, rfrfr()), found)
    assert list(tmp_path.iterdir()) == [file]
    other = tmp_path / f"n{file.name[1:]}"
    assert unfinished_file(file, 1) != unfinished_file(other, 1) != unfinished_file(other, 2)


@pytest.mark.parametrize("name", ["m" * 256, "\0"])
def test_names_that_no_file_can_have_are_refused_before_anything_is_mapped(tmp_path, name):
    states = []
    with pytest.raises(InvalidRequest, match="file: expected the name of a file"):
        map_workspace(rfrfr(), small_grid(), file=tmp_path / name, progress=states.append)
    assert states == []


def test_checkpoints_are_written_while_the_map_grows(tmp_path):
    file, sizes = tmp_path / "map.nc", []

    def look(state):
        if file.exists():
            sizes.append(read_map(file, rfrfr()).expanded)

    map_workspace(rfrfr(), small_grid(), file=file, checkpoint_every=0.0, progress=look)
    assert sizes == sorted(sizes)
    assert len(set(sizes)) > 3


def test_damaged_files_are_refused_or_read_never_something_else(tmp_path):
    """Bytes of the header and of all of it changed at random, and files cut short."""
    file, random = tmp_path / "map.nc", np.random.default_rng(5)
    write_map(small_map(), file)
    whole = file.read_bytes()
    refused = 0
    for number in range(300):
        content = bytearray(whole)
        for place in random.integers(0, (6000, len(whole))[number % 2], 1 + number % 5):
            content[place] = random.integers(256)
        if number % 10 == 0:
            content = content[: random.integers(len(whole))]
        file.write_bytes(content)
        try:
            read_map(file, rfrfr())
        except InvalidRequest as error:
            assert error.argument == "file"
            refused += 1
    assert refused > 50


@pytest.mark.parametrize("change", [0.01, 300.0, np.nan])
def test_cells_that_are_no_equilibria_any_more_are_told(tmp_path, change):
    """One was handed out, and who went on from it met an error without a word."""
    file, cell = tmp_path / "map.nc", int(np.flatnonzero(small_map().reached)[3])
    write_map(small_map(), file)
    with netcdf_file(file, "a", mmap=False) as content:
        state = np.array(content.variables["state"][:])
        state.reshape(small_map().grid.size, -1)[cell, 0] += change
        content.variables["state"][:] = state
    if np.isnan(change):
        with pytest.raises(InvalidRequest, match=r"damaged.*state of a cell that was reached"):
            read_map(file, rfrfr())
        return
    found = read_map(file, rfrfr())
    with pytest.raises(InvalidRequest, match=f"damaged: cell {cell} is no equilibrium"):
        found.equilibrium(cell)
    assert found.equilibrium(int(np.flatnonzero(found.reached)[0])).converged


def test_maps_of_something_else_are_not_gone_on_with(tmp_path):
    file = tmp_path / "map.nc"
    write_map(small_map(), file)
    other = pose_grid(rfrfr(), {"x": [-0.6, 0.6], "y": [-0.1, 0.8]}, resolution=0.1)
    with pytest.raises(InvalidRequest, match="a map of another grid"):
        map_workspace(rfrfr(), other, file=file)
    with pytest.raises(InvalidRequest, match="another branch"):
        map_workspace(rfrfr(), small_grid(), start=stable_elsewhere(rfrfr()), file=file)
    with pytest.raises(InvalidRequest, match="another robot_description"):
        read_map(file, six_rfs())
    loads = rfrfr().default_loads.with_(gravity=[0.0, -1.0, 0.0])
    with pytest.raises(InvalidRequest, match="other loads"):
        read_map(file, rfrfr(), loads)
    signed = rfrfr().default_loads.with_(gravity=[0.0, -0.0, 0.0], wrench_world=-np.zeros(6))
    assert read_map(file, rfrfr(), signed).loads is signed
    file.write_text("not a map")
    with pytest.raises(InvalidRequest, match="expected a NetCDF file"):
        read_map(file, rfrfr())
    with pytest.raises(InvalidRequest, match="expected a NetCDF file"):
        read_map(tmp_path / "missing.nc", rfrfr())
    assert list(tmp_path.iterdir()) == [file]
