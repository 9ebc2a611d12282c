# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures of robots, paths and maps; matplotlib is imported only by who draws with it."""
