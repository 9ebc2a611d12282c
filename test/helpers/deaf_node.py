# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A cpr_node that is stopped while it configures, in a library that makes another error of that."""

import os
import signal

from cpr_ros import node
from cpr_ros.node_run import run
from cpr_ros.process.stop_signal import Stopped


class DeafNode(node.CprNode):
    def _configure(self):
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            super()._configure()
        except Stopped:
            raise TypeError("missing 2 required positional arguments") from None


if __name__ == "__main__":
    run(DeafNode)
