"""The node ``cpr_node``: services, state and stability of one continuum parallel robot."""

from __future__ import annotations

import sys
import time
import traceback
from collections.abc import Callable
from typing import Any

import rclpy
from cpr_msgs.msg import StabilityMetrics
from cpr_msgs.srv import CheckStability, GetKinematoStatics, Predict, SolveForward, SolveInverse
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import SetParametersResult
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from cpr_core import CprError, Equilibrium, load_robot

from .analysis import fill_kinemato_statics, fill_prediction, fill_stability
from .conversions import Frames, equilibrium_to_message, joint_state, platform_pose
from .error_codes import error_code, success
from .parameters import declare, thresholds_problem
from .solver import Solution, Solver
from .stability_stream import Thresholds, stability_metrics

__all__ = ["CprNode", "main"]

#: A burst of requests waits in line; the default of ten would drop the others without a word.
SERVICE_QOS = QoSProfile(depth=1000)


class CprNode(Node):
    """ROS 2 face of a :class:`Solver`. One single-threaded executor serves everything."""

    def __init__(self) -> None:
        """Load the robot, find its home equilibrium and offer the interfaces.

        Raises:
            CprError: The description or its home cannot be used.
        """
        super().__init__("cpr_node")
        parameters = declare(self)
        self.frames = Frames(parameters.base_frame, parameters.platform_frame)
        if self.frames.base == self.frames.platform:
            raise CprError(
                f"expected two frames, base_frame and platform_frame are {self.frames.base}"
            )
        self.thresholds = self._thresholds({})
        problem = thresholds_problem(self.thresholds.warning, self.thresholds.stop)
        if problem:
            raise CprError(problem)

        logger = self.get_logger()
        robot = load_robot(parameters.robot, modes=parameters.modes or None)
        logger.info(f"{robot.description.source}: motors {', '.join(robot.motor_names)}")
        logger.info("finding home (after an installation the kernels are compiled, half a minute)")
        begin = time.monotonic()
        self.solver = Solver(robot, self.frames)
        home = self.solver.current.equilibrium
        # Everything a request needs is compiled now, not when a client waits.
        equilibrium_to_message(home, self.frames, self._stamp(), 0.0)
        logger.info(f"at home after {time.monotonic() - begin:.1f} s, index {home.index_locked}")

        if home.index_locked > 0:
            logger.warning("home is unstable: does every leg bow to the side it should?")

        self.joint_states = self.create_publisher(JointState, "joint_states", 10)
        self.platform_pose = self.create_publisher(PoseStamped, "~/platform_pose", 10)
        self.stability = self.create_publisher(StabilityMetrics, "~/stability", 10)
        for kind, name, callback in (
            (SolveForward, "solve_forward", self._on_forward),
            (SolveInverse, "solve_inverse", self._on_inverse),
            (
                GetKinematoStatics,
                "get_kinemato_statics",
                self._about_an_equilibrium(fill_kinemato_statics),
            ),
            (Predict, "predict", self._about_an_equilibrium(fill_prediction)),
            (CheckStability, "check_stability", self._about_an_equilibrium(fill_stability)),
        ):
            self.create_service(kind, f"~/{name}", callback, qos_profile=SERVICE_QOS)
        self.create_timer(1.0 / parameters.state_rate, self._publish_state)
        self.create_timer(1.0 / parameters.stability_rate, self._publish_stability)
        self.add_on_set_parameters_callback(self._on_parameters)
        logger.info("ready")

    def _on_forward(
        self, request: SolveForward.Request, response: SolveForward.Response
    ) -> SolveForward.Response:
        return self._answer(lambda: self._fill(self.solver.forward(request), response), response)

    def _on_inverse(
        self, request: SolveInverse.Request, response: SolveInverse.Response
    ) -> SolveInverse.Response:
        return self._answer(lambda: self._fill(self.solver.inverse(request), response), response)

    def _about_an_equilibrium(
        self, fill: Callable[[Equilibrium, Any, Any], None]
    ) -> Callable[[Any, Any], Any]:
        """Callback of a service that asks about one equilibrium."""

        def callback(request: Any, response: Any) -> Any:
            return self._answer(
                lambda: fill(self.solver.equilibrium_of(request), request, response), response
            )

        return callback

    def _fill(self, solution: Solution, response: Any) -> None:
        response.solution = equilibrium_to_message(
            solution.equilibrium, self.frames, self._stamp(), solution.solve_time
        )

    def _answer(self, fill: Callable[[], None], response: Any) -> Any:
        """Fill a response. An exception must not leave a callback: the client would wait for ever."""
        try:
            fill()
            response.error_code = success()
        except Exception as error:
            response.error_code = error_code(error)
            if not isinstance(error, CprError):
                self.get_logger().error(traceback.format_exc())
        return response

    def _publish_state(self) -> None:
        equilibrium, stamp = self.solver.current.equilibrium, self._stamp()
        self.joint_states.publish(joint_state(equilibrium, self.frames, stamp))
        self.platform_pose.publish(platform_pose(equilibrium, self.frames, stamp))

    def _publish_stability(self) -> None:
        solution = self.solver.current
        self.stability.publish(
            stability_metrics(
                solution.equilibrium,
                self.thresholds,
                self.frames,
                self._stamp(),
                solution.solve_time,
            )
        )

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        """Take over new thresholds, all of one call together."""
        thresholds = self._thresholds({parameter.name: parameter for parameter in parameters})
        problem = thresholds_problem(thresholds.warning, thresholds.stop)
        if not problem:
            self.thresholds = thresholds
        return SetParametersResult(successful=not problem, reason=problem)

    def _thresholds(self, changed: dict[str, Parameter]) -> Thresholds:
        def value(name: str) -> float:
            return (changed.get(name) or self.get_parameter(name)).value

        return Thresholds(warning=value("margin_warning"), stop=value("margin_stop"))

    def _stamp(self) -> Any:
        return self.get_clock().now().to_msg()


def main(arguments: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; exit status 0, or 1 if it cannot start."""
    try:
        rclpy.init(args=arguments)
    except Exception as error:
        print(f"cpr_node: {error}", file=sys.stderr)
        return 1
    executor = SingleThreadedExecutor()
    node = None
    try:
        node = CprNode()
        executor.add_node(node)
        _spin(node, executor)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except (CprError, ParameterException) as error:
        print(f"cpr_node: {error}", file=sys.stderr)
        return 1
    except Exception:
        if rclpy.ok():
            raise
        # A signal took the context away while the node was starting.
    finally:
        executor.shutdown()
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


def _spin(node: CprNode, executor: SingleThreadedExecutor) -> None:
    """Spin as long as ROS runs; no message of a client may end the node."""
    while rclpy.ok():
        try:
            executor.spin_once()
        except (KeyboardInterrupt, ExternalShutdownException):
            raise
        except Exception:  # rclpy raises for malformed parameter messages, for one
            if rclpy.ok():
                node.get_logger().error(traceback.format_exc())


if __name__ == "__main__":
    sys.exit(main())
