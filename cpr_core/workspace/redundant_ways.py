# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Ways between the cells of a robot with more motors than controlled coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..kernels.kernel_arrays import LoadArrays
from ..kernels.square_problem import Configuration
from ..model.equilibrium import Equilibrium
from ..model.equilibrium_steps import equilibrium_at
from ..model.kinemato_statics import kinemato_statics
from ..model.robot import Robot
from ..solving.objectives import Objective
from ..solving.redundant_walk import walk_to
from .batch_kernel import Analyses, Arrivals, Cells, Ways
from .batches import analyses_of
from .cell_layout import INVERSE_MARGIN, SIGN_COUNT
from .cell_problem import CellProblem
from .first_cell import signs_row, target_at
from .way_kernel import ARRIVED, BLOCKED

__all__ = ["RedundantWays"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RedundantWays:
    """Tasks of an executor: walks, each ending where an objective is least.

    Attributes:
        robot: The robot.
        loads: Loads in force.
        objective: What is made least in every cell; one that does not depend on the way there.
    """

    robot: Robot
    loads: Loads
    objective: Objective

    def analyses_and_arrivals(
        self, problem: CellProblem, cells: Cells, ways: Ways
    ) -> tuple[Analyses, Arrivals]:
        """Analyse cells and go from them to their neighbours."""
        analyses, load_arrays = analyses_of(problem, cells), self.robot.load_arrays(self.loads)
        for cell in range(len(cells.state)):
            model = kinemato_statics(self._at(cells, cell, load_arrays))
            analyses.measures[cell, INVERSE_MARGIN] = model.singular_values("inverse")[0]
        return analyses, self.arrivals(problem, cells, ways)

    def arrivals(self, problem: CellProblem, cells: Cells, ways: Ways) -> Arrivals:
        """Go from cells to targets."""
        load_arrays = self.robot.load_arrays(self.loads)
        starts: dict[int, Equilibrium] = {}
        ends, status, fractions = [], [], []
        for origin, coordinates in zip(ways.origin.tolist(), ways.targets, strict=True):
            if origin not in starts:
                starts[origin] = self._at(cells, origin, load_arrays)
            start = starts[origin]
            target = target_at(problem, coordinates, start)
            walk = walk_to(start, target, self.loads, objective=self.objective)
            ends.append(walk.last)
            status.append(ARRIVED if walk.arrived else BLOCKED)
            fractions.append(1.0 if walk.stopped is None else walk.stopped.fraction)
        count, size = len(ends), cells.state.shape[1]
        signs = [signs_row(end, 0) for end in ends]  # walks need no sign to stay on their branch
        return Arrivals(
            status=np.array(status, np.int64),
            fraction=np.array(fractions, float),
            state=np.array([end.state for end in ends]).reshape(count, size),
            rotation=np.array([end.platform_rotation for end in ends]).reshape(count, 3, 3),
            position=np.array([end.platform_position for end in ends]).reshape(count, 3),
            signs=np.array(signs, np.int64).reshape(count, SIGN_COUNT),
            efforts=np.array([end.efforts for end in ends]).reshape(count, self.robot.motor_count),
            energy=np.array([end.energy for end in ends], float),
        )

    def _at(self, cells: Cells, cell: int, load_arrays: LoadArrays) -> Equilibrium:
        """The equilibrium of a cell."""
        place = Configuration(cells.state[cell], cells.rotation[cell], cells.position[cell])
        return equilibrium_at(self.robot, self.loads, load_arrays, place)
