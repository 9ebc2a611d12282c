# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The same map, bit for bit, wherever it is made."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest
from helpers.workspace_cases import assert_same, rfrfr, small_grid, small_map

from cpr_core import load_robot, solve_home
from cpr_core.workspace import map_workspace, pose_grid


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_threads(workers):
    assert_same(map_workspace(rfrfr(), small_grid(), workers=workers), small_map())
    with ThreadPoolExecutor(workers) as pool:
        assert_same(map_workspace(rfrfr(), small_grid(), executor=pool), small_map())


@pytest.mark.slow
def test_processes():
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert_same(map_workspace(rfrfr(), small_grid(), executor=pool), small_map())


@pytest.mark.slow
def test_a_dask_cluster_of_separate_processes():
    from dask.distributed import Client, LocalCluster

    robot = load_robot("six_rfs", modes=3)
    x, y, z = solve_home(robot).platform_position
    grid = pose_grid(
        robot, {"x": [x - 0.05, x + 0.05], "y": [y - 0.05, y + 0.05]}, {"z": z}, resolution=0.02
    )
    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        Client(cluster) as client,
    ):
        executor = client.get_executor()
        assert_same(map_workspace(rfrfr(), small_grid(), executor=executor), small_map())
        spatial = map_workspace(robot, grid, executor=executor)
    assert_same(spatial, map_workspace(robot, grid, workers=0))
