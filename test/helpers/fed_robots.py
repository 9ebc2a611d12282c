# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A shipped robot whose rods rollers feed, from other zeros than those of their lengths."""

import math

import numpy as np

from helpers.yaml_content import shipped_content

#: Way per turn of every roller, one of which turns the other way [m], and lengths at zero [m].
LEADS, OFFSETS = (0.05, -0.02, 0.01, 0.1, 0.04, 0.03), (0.3, 0.2, 0.6, -0.1, 0.45, 0.0)
RATIOS = np.array(LEADS) / (2.0 * math.pi)


def plain_content():
    """Description of the robot without rollers."""
    return shipped_content("gough_stewart")


def fed(content):
    """The same with rollers, in the short form or with chains."""
    for leg, lead, offset in zip(content["legs"], LEADS, OFFSETS, strict=True):
        if "chain" in leg:
            (motor,) = (element for element in leg["chain"] if "motor" in element)
        else:
            motor = leg["motor"]
        motor |= {"lead": lead, "offset": offset}
        if limits := motor.get("limits"):
            ratio = lead / (2.0 * math.pi)
            ends = [(length - offset) / ratio for length in limits["position"]]
            motor["limits"] = {
                "position": sorted(ends),
                "speed": limits["speed"] / abs(ratio),
                "effort": limits["effort"] * abs(ratio),
            }
    content["home"]["motors"] = motors_of(content["home"]["motors"]).tolist()
    return content


def motors_of(lengths):
    """Motor positions at which rods are so long, (6,) [rad]."""
    return (np.asarray(lengths) - OFFSETS) / RATIOS
