# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""``python -m cpr_core.command_line`` is ``cpr``."""

import sys

from .command import main

sys.exit(main())
