"""Section 5.3: what the open-loop experiments are said to be."""

import jax.numpy as jnp

from experiments.paper.claim import AS_PRINTED, Claim, Verdict, at_least, digits
from experiments.paper.topics.open_loop.numbers import POSES, TORQUES, open_loop
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.prototype import consistent


def _inputs(experiment: int) -> tuple[Claim, ...]:
    numbers = (*POSES[experiment - 1], *TORQUES[experiment - 1])
    names = ("x", "y", "τ₁", "τ₂")
    texts = tuple(f"{n:.3f}" for n in numbers[:2]) + tuple(f"{n:.2f}" for n in numbers[2:])
    return tuple(
        Claim(
            "table2",
            "Table 2",
            f"{name} of experiment {experiment}",
            text,
            "m" if name in ("x", "y") else "N m",
            digits(text),
            AS_PRINTED,
            lambda number=number: number,
            Verdict.GIVEN,
        )
        for name, text, number in zip(names, texts, numbers, strict=True)
    )


def _runs(experiment: int) -> tuple[Claim, ...]:
    return (
        Claim(
            "table2",
            "5.3",
            f"experiment {experiment} avoids the frame: its least distance",
            "no collision",
            "mm",
            at_least(0.0),
            "no collision",
            lambda: 1e3 * open_loop().margin(experiment),
            Verdict.AFTER_ERRATUM,
            "E1, E25: with r = 73 mm and the drives' inertia",
            heavy=True,
        ),
        Claim(
            "table2",
            "5.3",
            f"experiment {experiment} is a “large movement”",
            "large",
            "mm",
            at_least(400.0),
            "over half of what is free in the direction of the smaller side, 0.83 m",
            lambda: 1e3 * open_loop().travel(experiment),
            Verdict.AFTER_ERRATUM,
            "E1: as printed it goes 15 cm at most",
            heavy=True,
        ),
    )


CLAIMS: tuple[Claim, ...] = (
    *(claim for experiment in (1, 2, 3, 4) for claim in _inputs(experiment)),
    *(claim for experiment in (1, 2, 3, 4) for claim in _runs(experiment)),
    Claim(
        "fig14",
        "Table 2, Fig. 14",
        "torque that the drives give in experiment 1, 10 V",
        "4.85",
        "N m",
        digits("4.85"),
        AS_PRINTED,
        lambda: float(motor_torque(consistent().drive, jnp.asarray(4.85 / 0.482))),
        Verdict.NOT_REPRODUCIBLE,
        "E20: 4.82 N m at their limit",
    ),
)
"""Claims of section 5.3."""
