# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Reference methods that share no kernel but rotations with the strain-mode model they check.

Nor its layouts: that moments stand before forces is written anew, so that a slip there would be seen.
"""
