"""Small made-up tunings for the exports' tests, between them every kind of shaper."""

import jax.numpy as jnp

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.loop.margins import Margins
from tuning.result.regional_shaper import Region, RegionalShaper, ResidualVibration
from tuning.result.tuning import FittedSetting, Tuning
from tuning.shapers.catalogue import ei, um_zv, zv

WIDTH, HEIGHT = 2.224, 1.112  # m, of the frame
MARGINS = (40.0, 1.0, 0.025, 700.0, 30.0, 1.3)  # made up: no export carries them


def tuning_of(controller, robot, shapers, *, columns):
    """A grid of regions at some settings of the pretension, and one for all at more."""
    rows = (len(shapers) - 1) // columns
    regions = [
        Region(
            (WIDTH * i / columns, WIDTH * (i + 1) / columns),
            (HEIGHT * j / rows, HEIGHT * (j + 1) / rows),
            (200.0, 350.0),
        )
        for j in range(rows)
        for i in range(columns)
    ]
    # A pose that lies in two of them: the first counts.
    regions.append(Region((0.0, WIDTH), (0.0, HEIGHT), (100.0, 350.0)))
    left = ResidualVibration(0.01, 0.05)
    return Tuning(
        controller=controller,
        margins=Margins(*(jnp.asarray(number) for number in MARGINS)),
        shapers=tuple(
            RegionalShaper(region, 0.5, shaper, 3.1, (3.0, 3.2), 0.01, True, left)
            for region, shaper in zip(regions, shapers, strict=True)
        ),
        predicted=(),
        robots=(FittedSetting(350.0, robot),),
    )


def plain():
    """The paper's controller; impulses on the samples and between them, negative ones."""
    shapers = (
        ei(3.1234, 0.013),
        um_zv(2.4, 0.03),
        Shaper([0.0], [1.0]),
        Shaper([0.0, 0.2, 0.2], [0.25, 0.5, 0.25]),
        # Later and closer together than a sample.
        Shaper([0.00031, 0.00078, 0.00205], [0.5, 0.2, 0.3]),
    )
    return tuning_of(published_pd(), exact(consistent()), shapers, columns=2)


def filtered():
    """Another rig at 500 Hz, with a filter of its derivative and a lower limit."""
    rig = replace(
        consistent(),
        {"effective_radius": 0.05, "voltage_limit": 6.0, "drive_inertia": 0.03},
    )
    shapers = (zv(3.9, 0.1), ei(2.4, 0.0))
    return tuning_of(PD(61.0, 1.3, 2e-3, 5e-3), exact(rig), shapers, columns=1)


TUNINGS = (plain(), filtered())
NAMES = ("plain", "filtered")
