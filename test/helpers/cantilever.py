# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A clamped rod in the plane with a free platform at its tip, of which textbooks know all."""

#: Of its rod [m], and how stiff it is in bending [N m^2].
LENGTH, BENDING = 0.5, 0.2


def cantilever(**rod):
    """One clamped rod of length 0.5 m with a free platform at its tip, in the plane."""
    leg = {
        "base": {"position": [0, 0, 0], "tangent": [1, 0, 0]},
        "motor": {"type": "welded"},
        "tip": {"type": "fixed", "position": [0, 0, 0], "tangent": [1, 0, 0]},
        "rod": {
            "length": 0.5,
            "section": {"shape": "given", "torsion": 0.1, "bending_2": 0.2, "bending_3": 0.2},
            **rod,
        },
    }
    return {
        "name": "cantilever",
        "space": "planar",
        "rod": leg["rod"],
        "legs": [leg],
        "strain": {"bending_3": 10},
        "stations": [0.4],
        "controlled": [],
        "home": {
            "motors": [],
            "platform": {"position": [0.5, 0, 0]},
            "strain": [{}],
        },
    }
