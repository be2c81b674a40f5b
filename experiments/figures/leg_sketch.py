"""A planned leg at a glance: its way in the frame, and what the drives are told besides."""

import html

import numpy as np
from jaxtyping import Float
from markupsafe import Markup

from scdpr_jax.robot.parameters import Robot
from tuning.plan.plan import Plan

_POINTS = 160
_DRIVES = (
    "stroke: var(--d-blue); stroke-width: 3",
    "stroke: var(--d-red); stroke-width: 2; stroke-dasharray: 6 4",
)
_WIDE, _HIGH = 600.0, 200.0
"""Size of the commands' drawing [units]."""


def way_sketch(robot: Robot, plan: Plan) -> Markup:
    """The way of a leg in the frame.

    Args:
        robot: The robot.
        plan: The plan.

    Returns:
        A drawing to scale.
    """
    width, height = 1e3 * float(robot.frame.width), 1e3 * float(robot.frame.height)
    x, y = 1e3 * plan.position[:, 0], height - 1e3 * plan.position[:, 1]
    spoken = (
        f"From x {x[0]:.0f}, y {height - y[0]:.0f} mm to x {x[-1]:.0f}, "
        f"y {height - y[-1]:.0f} mm in a frame of {width:.0f} by {height:.0f} mm."
    )
    return Markup(
        f'<svg viewBox="-20 -20 {width + 40:.0f} {height + 40:.0f}" role="img" '
        f'aria-label="{html.escape(spoken, quote=True)}">'
        f'<rect width="{width:.0f}" height="{height:.0f}" style="fill: none; stroke: '
        'var(--d-grey); stroke-width: 12"/>'
        f"{_line(x, y, 'stroke: var(--d-blue); stroke-width: 2')}"
        f'<circle cx="{x[0]:.0f}" cy="{y[0]:.0f}" r="22" style="fill: var(--paper); stroke: '
        'var(--d-blue); stroke-width: 10"/>'
        f'<circle cx="{x[-1]:.0f}" cy="{y[-1]:.0f}" r="26" style="fill: var(--d-blue)"/></svg>'
    )


def command_sketch(plan: Plan, *, limit: float) -> Markup:
    """The feed-forward of both drives over time, and their limit.

    Args:
        plan: The plan.
        limit: Largest command of either sign [V].

    Returns:
        A drawing.
    """
    last = float(plan.time[-1])
    x = _WIDE * plan.time / last
    lines = "".join(
        _line(x, _HIGH / 2 * (1 - 0.9 * plan.feedforward[:, motor] / limit), drive)
        for motor, drive in enumerate(_DRIVES)
    )
    ends = "".join(
        f'<path d="M0 {_HIGH / 2 * (1 + side * 0.9):.1f}H{_WIDE:.0f}" style="stroke: '
        f'var(--d-grey); stroke-dasharray: {dashes}" vector-effect="non-scaling-stroke"/>'
        for side, dashes in ((-1, "6 4"), (0, "none"), (1, "6 4"))
    )
    largest = float(np.abs(plan.feedforward).max())
    spoken = (
        f"Feed-forward of both drives over {last:.2f} s, at most {largest:.1f} V of "
        f"{limit:g} V."
    )
    return Markup(
        f'<svg viewBox="0 0 {_WIDE:.0f} {_HIGH:.0f}" role="img" '
        f'aria-label="{html.escape(spoken, quote=True)}">{ends}{lines}</svg>'
    )


def _line(x: Float[np.ndarray, " n"], y: Float[np.ndarray, " n"], stroke: str) -> str:
    kept = np.unique(np.linspace(0, len(x) - 1, _POINTS).astype(int))
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x[kept], y[kept], strict=True))
    return (
        f'<polyline points="{points}" style="fill: none; {stroke}" '
        'vector-effect="non-scaling-stroke"/>'
    )
