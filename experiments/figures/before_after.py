"""One leg before and after, moving: a drawing that stands by itself on any page.

A page of a repository shows it as an image, so that it has its colours, its style sheet and
its own ground in it, and no script. Where motion isn't wanted it shows the end.
"""

import dataclasses
import html
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from experiments.figures.robot_film import RobotShapes, Track, keyframes, poses_at
from experiments.page.theme import declarations
from scdpr_jax.robot.parameters import Robot

_RATE = 15.0
"""Poses a second: enough for the eye, and four a period of a vibration of 4 Hz [Hz]."""
_WIDTH, _GAP, _MARGIN = 420.0, 24.0, 18.0
"""Width of a side, room between both and about them [px]."""
_TITLE, _CURVE = 36.0, 150.0
"""Heights of a side's title and of its curve [px]."""
_POINTS = 240
"""Points of a curve."""


@dataclasses.dataclass(frozen=True, eq=False)
class Side:
    """One of the two motions."""

    title: str
    """What it is called."""
    track: Track
    """The motion, from the leg's begin."""
    outcome: str
    """What it leaves, in a few words."""


def before_after(
    robot: Robot, sides: Sequence[Side], *, target: float, leg_time: float, name: str
) -> str:
    """Motions of a robot beside each other, and what is left once they have arrived.

    Args:
        robot: The robot.
        sides: The motions, of one length.
        target: Where the end-effector is to go, $x_e$ [m].
        leg_time: When it is to be there [s].
        name: What the drawing shows, for who can't see it.

    Returns:
        An SVG file.
    """
    shapes = RobotShapes(robot)
    _, _, wide, high = map(float, shapes.box.split())
    robot_height = _WIDTH * high / wide
    last = min(float(side.track.time[-1]) for side in sides)
    instants = np.linspace(0, last, int(_RATE * last) + 1)
    reach = _reach(sides, target, leg_time)
    rules, drawn = [], []
    for number, side in enumerate(sides):
        key = f"s{number}"
        moving = []
        for part, shape, transforms in shapes.moving(poses_at(side.track, instants)):
            rules.append(keyframes(f"{key}-{part}", transforms))
            moving.append(shape.format(attributes=f' id="{key}-{part}" class="m"'))
        left = _MARGIN + number * (_WIDTH + _GAP)
        drawn.append(
            f'<g transform="translate({left:g} {_MARGIN:g})">'
            f'<text y="20" class="title">{html.escape(side.title)}</text>'
            f'<svg y="{_TITLE:g}" width="{_WIDTH:g}" height="{robot_height:.1f}" '
            f'viewBox="{shapes.box}">{shapes.still}{"".join(moving)}</svg>'
            f'<g transform="translate(0 {_TITLE + robot_height + 8:.1f})">'
            f"{_curve(side, key, target, (leg_time, last), reach)}</g></g>"
        )
    size = (
        2 * _MARGIN + len(sides) * _WIDTH + (len(sides) - 1) * _GAP,
        2 * _MARGIN + _TITLE + robot_height + 8 + _CURVE + 30,
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]:g} {size[1]:.0f}" '
        f'role="img" aria-label="{html.escape(name, quote=True)}">'
        f"<style>{_style(last, rules)}</style>"
        f'<rect width="100%" height="100%" rx="8" style="fill: var(--paper)"/>'
        f"{''.join(drawn)}</svg>\n"
    )


def _style(seconds: float, rules: Sequence[str]) -> str:
    """The style sheet: colours by day and by night, and the motion."""
    return (
        f":root {{ {declarations(night=False)} }}\n"
        f"@media (prefers-color-scheme: dark) {{ :root {{ {declarations(night=True)} }} }}\n"
        "text { font: 22px system-ui, sans-serif; fill: var(--ink) }\n"
        ".title { font-weight: 600 } .soft { fill: var(--soft) }\n"
        ".end { text-anchor: end }\n"
        f".m {{ animation-duration: {seconds + 1:.2f}s; animation-iteration-count: infinite; "
        "animation-timing-function: linear }\n"
        "@keyframes shown { 0% { transform: scaleX(0) } "
        f"{100 * seconds / (seconds + 1):.1f}%, 100% {{ transform: scaleX(1) }} }}\n"
        ".reveal { animation-name: shown }\n"
        "@media (prefers-reduced-motion: reduce) { .m { animation: none } }\n"
        + "\n".join(rules)
    )


def _reach(sides: Sequence[Side], target: float, leg_time: float) -> float:
    """Half of a curve's height, alike for all sides [mm]."""
    away = [np.abs(_away(side, target)[1][side.track.time >= leg_time]).max() for side in sides]
    return 1.15 * float(max(away))


def _away(
    side: Side, target: float
) -> tuple[Float[np.ndarray, " rows"], Float[np.ndarray, " rows"]]:
    """Times [s], and how far the end-effector is from its target [mm]."""
    return side.track.time, 1e3 * (side.track.position[:, 0] - target)


def _curve(side: Side, key: str, target: float, span: tuple[float, float], reach: float) -> str:
    """How far the end-effector is from its target once it has arrived, appearing."""
    first, last = 0.0, span[1]
    time, away = _away(side, target)
    instants = np.linspace(first, last, _POINTS)
    across = _WIDTH * (instants - first) / (last - first)
    mm = np.interp(instants, time, away)
    down = _CURVE / 2 * (1 - np.clip(mm / reach, -1.2, 1.2))
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across, down, strict=True))
    arrival = _WIDTH * span[0] / last
    tick = _nice(reach)
    scale = _CURVE / 2 / reach
    marks = "".join(
        f'<line x1="{arrival:.1f}" x2="{_WIDTH:g}" y1="{_CURVE / 2 - at * scale:.1f}" '
        f'y2="{_CURVE / 2 - at * scale:.1f}" style="stroke: var(--d-grid)"/>'
        f'<text x="{arrival - 6:.1f}" y="{_CURVE / 2 - at * scale + 8:.1f}" '
        f'class="soft end">{_signed(at)} mm</text>'
        for at in (-tick, 0.0, tick)
    )
    return (
        f'<clipPath id="{key}-clip"><rect x="{arrival:.1f}" width="{_WIDTH - arrival:.1f}" '
        f'height="{_CURVE:g}"/></clipPath>'
        f'<clipPath id="{key}-shown"><rect width="{_WIDTH:g}" height="{_CURVE:g}" '
        f'class="m reveal"/></clipPath>{marks}'
        f'<line x1="{arrival:.1f}" x2="{arrival:.1f}" y2="{_CURVE:g}" '
        'style="stroke: var(--d-grey); stroke-dasharray: 3 3"/>'
        f'<g clip-path="url(#{key}-clip)"><polyline points="{points}" '
        f'clip-path="url(#{key}-shown)" style="fill: none; stroke: var(--d-red); '
        'stroke-width: 1.8"/></g>'
        f'<text y="{_CURVE / 2 - 6:.0f}" class="soft">from the</text>'
        f'<text y="{_CURVE / 2 + 22:.0f}" class="soft">target</text>'
        f'<text x="{_WIDTH:g}" y="{_CURVE + 24:g}" class="end">{html.escape(side.outcome)}'
        "</text>"
    )


def _nice(reach: float) -> float:
    """A round number that fits [mm]."""
    return max(
        (each for each in (0.5, 1.0, 2.0, 5.0, 10.0, 20.0) if each <= 0.9 * reach), default=0.2
    )


def _signed(number: float) -> str:
    return f"{number:+g}".replace("-", "−") if number else "0"
