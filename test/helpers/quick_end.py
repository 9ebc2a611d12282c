# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Programs that tests start end without looking for garbage three times in what they imported: 0.2 s."""

QUICK_END = "import atexit, gc; atexit.register(gc.freeze)\n"
