# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A cpr_node whose solver, and ends of motions, can be made to fail: services /fail and /work."""

from std_srvs.srv import Trigger

from cpr_ros import node
from cpr_ros.following import goals
from cpr_ros.following.setpoint_following import SetpointFollower
from cpr_ros.following.trajectory_following import Trajectories
from cpr_ros.interface import move_action
from cpr_ros.maps import map_action
from cpr_ros.maps.map_process import MapProcess
from cpr_ros.node_run import run
from cpr_ros.operation import solver

_broken = False


def breakable(work):
    def work_or_fail(*arguments, **options):
        if _broken:
            raise ArithmeticError("forced by a test")
        return work(*arguments, **options)

    return work_or_fail


for place, names in (
    (goals, ("solve_forward", "solve_inverse")),
    (solver, ("solve_forward", "solve_inverse")),
    (map_action, ("map_order",)),
    (MapProcess, ("stop",)),
    (SetpointFollower, ("drop",)),
    (move_action, ("goal_of",)),
    (Trajectories, ("cancel", "take")),
):
    for name in names:
        setattr(place, name, breakable(getattr(place, name)))


class FailingNode(node.CprNode):
    def __init__(self, stop):
        super().__init__(stop)
        for name, broken in (("/fail", True), ("/work", False)):
            self.create_service(Trigger, name, self._setter(broken))

    def _setter(self, broken):
        def callback(_request, response):
            global _broken
            _broken = broken
            response.success = True
            return response

        return callback


if __name__ == "__main__":
    run(FailingNode)
