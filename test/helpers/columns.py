# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot of one rod: what Euler and others knew the answers of."""

import numpy as np

from cpr_core import Robot
from cpr_core.description.chain import ChainRod, Link
from cpr_core.description.leg_description import LegDescription
from cpr_core.description.robot_description import HomeGuess, RobotDescription
from cpr_core.rods.rod import Rod, StrainModes
from cpr_core.rods.sections import CircularSection

LENGTH = 0.5
ROD = Rod(LENGTH, CircularSection(0.001), 2.1e11, 8.2e10)
TORSION, BENDING, _ = ROD.rigidities
AT_TIP = (0.0, 0.0, 0.0)


def column(motor, joint, *, planar=True, modes=8, robot=Robot, before=(), behind=()):
    """One rod along x, elements of a chain before and behind it; the platform at its tip."""
    counts = (0, 0, modes) if planar else (2, modes, modes)
    elements = (*before, ChainRod(ROD, StrainModes(counts)), *behind) if before or behind else None
    links = [element for element in (*before, *behind) if isinstance(element, Link)]
    tip = LENGTH + sum(link.offset[0] for link in links)
    leg = LegDescription(
        name="leg1",
        rod=ROD,
        modes=StrainModes(counts),
        base_position=np.zeros(3),
        base_rotation=np.eye(3),
        motor=motor,
        joint=joint,
        elements=elements,
    )
    home = HomeGuess(
        motors=np.zeros(0),
        platform_position=np.array([tip, 0.0, 0.0]),
        platform_rotation=np.eye(3),
        strain=((np.zeros(0),) * 3,),
    )
    return robot(
        RobotDescription(
            name="column",
            source="test",
            planar=planar,
            point_platform=False,
            platform_mass=0.0,
            center_of_mass=np.zeros(3),
            legs=(leg,),
            controlled=(),
            home=home,
        )
    )


class Guided(Robot):
    """Its platform slides along x only."""

    @property
    def platform_coordinates(self):
        return super().platform_coordinates._replace(axes=np.array([3]))
