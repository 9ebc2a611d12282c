# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A cpr_node whose solver can be made to fail: services /fail and /work."""

from std_srvs.srv import Trigger

from cpr_ros import goals, node, solver
from cpr_ros.node_run import run

_broken = False


def breakable(solve):
    def solve_or_fail(*arguments, **options):
        if _broken:
            raise ArithmeticError("forced by a test")
        return solve(*arguments, **options)

    return solve_or_fail


for module in (goals, solver):
    for name in ("solve_forward", "solve_inverse"):
        setattr(module, name, breakable(getattr(module, name)))


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
