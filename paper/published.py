# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The numbers the paper prints in its Tables I to VI, as printed."""

from __future__ import annotations

__all__ = [
    "TABLE_II",
    "TABLE_III",
    "TABLE_IV_ANGLE",
    "TABLE_IV_POSITION",
    "TABLE_I_MOTORS",
    "TABLE_I_POSITION",
    "TABLE_V",
    "TABLE_VI",
]

#: By modes: smallest, largest, mean position error [mm].
TABLE_I_POSITION = {
    3: ("0.11", "9.22", "1.50"),
    4: ("4.5e-3", "2.68", "0.68"),
    5: ("6.5e-5", "0.13", "0.029"),
}
#: By modes: smallest, largest, mean motor angle error [mdeg].
TABLE_I_MOTORS = {
    3: ("13.75", "18.50", "16.13"),
    4: ("3.10", "3.18", "3.14"),
    5: ("1.40e-2", "0.15", "8.12e-2"),
}
#: By elements: smallest, largest, mean position error [mm].
TABLE_II = {
    50: ("1.50", "53.44", "12.94"),
    100: ("0.72", "27.76", "6.59"),
    500: ("0.14", "5.71", "1.34"),
    1000: ("0.07", "2.86", "0.67"),
}
#: By n_c: total time [s] of Mod. #1, #2 and #3 on the RFRFR path.
TABLE_III = {
    50: ("2.8", "1.9", "325"),
    30: ("1.6", "1.1", "202"),
    15: ("0.8", "0.7", "105"),
    10: ("0.6", "0.4", "87"),
    5: ("0.3", "0.3", "57"),
}
#: By modes: smallest, largest, mean position error [mm].
TABLE_IV_POSITION = {
    3: ("0.09", "4.49", "1.14"),
    4: ("0.02", "1.04", "0.28"),
    5: ("3.0e-4", "0.14", "3.6e-2"),
}
#: By modes: smallest, largest, mean angle error [deg].
TABLE_IV_ANGLE = {
    3: ("0.10", "1.24", "0.37"),
    4: ("6.8e-3", "0.30", "0.08"),
    5: ("1.8e-3", "0.04", "0.01"),
}
#: Smallest, largest, mean error of motors 1 to 6 [mdeg].
TABLE_V = {
    "Min": ("1.5e-2", "0.33", "8.9e-4", "3.7e-4", "9.2e-4", "4.1e-3"),
    "Max": ("52.22", "36.59", "31.59", "13.80", "3.68", "176.84"),
    "Mean": ("10.58", "4.17", "2.47", "1.62", "0.77", "19.06"),
}
#: By n_c: total time [s] of Mod. #1 and #2 on the 6-RFS path.
TABLE_VI = {
    50: ("130", "191"),
    30: ("80", "124"),
    15: ("46", "62"),
    10: ("27", "41"),
    5: ("13", "26"),
}
