# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How DDS writes a message, as far as the node reads and writes bytes itself where rclpy is slow.

Fields follow each other, every number aligned to its size. Whoever reads or writes them looks whether
they are written like this, and else leaves it to rclpy.
"""

from __future__ import annotations

import struct

__all__ = ["FIRST", "LITTLE_ENDIAN", "STAMP"]

#: What a message begins with whose numbers are written little-endian.
LITTLE_ENDIAN = b"\x00\x01"
#: Where its first field begins, which alignment counts from.
FIRST = 4
#: Seconds and nanoseconds, what a header begins with.
STAMP = struct.Struct("<iI")
