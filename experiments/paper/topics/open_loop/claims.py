"""Section 5.3: what the open-loop experiments are said to be."""

import jax.numpy as jnp

from experiments.paper.claim import Claim, Printed, at_least
from experiments.paper.topics.open_loop.numbers import POSES, TORQUES, open_loop
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.prototype import consistent


def _inputs(experiment: int) -> tuple[Claim, ...]:
    numbers = (*POSES[experiment - 1], *TORQUES[experiment - 1])
    names = ("x", "y", "τ₁", "τ₂")
    texts = tuple(f"{n:.3f}" for n in numbers[:2]) + tuple(f"{n:.2f}" for n in numbers[2:])
    return tuple(
        Printed("Table 2", text, "m" if name in ("x", "y") else "N m").given(
            f"{name} of experiment {experiment}", lambda number=number: number
        )
        for name, text, number in zip(names, texts, numbers, strict=True)
    )


def _runs(experiment: int) -> tuple[Claim, ...]:
    return (
        Printed("5.3", "no collision", "mm", at_least(0.0), "no collision").after_erratum(
            f"experiment {experiment} avoids the frame: its least distance",
            lambda: 1e3 * open_loop().margin(experiment),
            "E1, E25: with r = 73 mm and the drives' inertia",
            heavy=True,
        ),
        Printed(
            "5.3",
            "large",
            "mm",
            at_least(400.0),
            "over half of what is free in the direction of the smaller side, 0.83 m",
        ).after_erratum(
            f"experiment {experiment} is a “large movement”",
            lambda: 1e3 * open_loop().travel(experiment),
            "E1: as printed it goes 15 cm at most",
            heavy=True,
        ),
    )


TABLE2: tuple[Claim, ...] = (
    *(claim for experiment in (1, 2, 3, 4) for claim in _inputs(experiment)),
    *(claim for experiment in (1, 2, 3, 4) for claim in _runs(experiment)),
)
"""Claims on the four experiments."""

FIG14: tuple[Claim, ...] = (
    Printed("Table 2, Fig. 14", "4.85", "N m").not_reproducible(
        "torque that the drives give in experiment 1, 10 V",
        lambda: float(motor_torque(consistent().drive, jnp.asarray(4.85 / 0.482))),
        "E20: 4.82 N m at their limit",
    ),
)
"""Claims on the torques."""
