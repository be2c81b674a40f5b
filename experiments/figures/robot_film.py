"""The robot moving: a drawing that a style sheet animates, without a script.

It stands still until the reader starts it. Where motion isn't wanted, and on paper, a strip of
poses takes its place.
"""

import dataclasses
import html
from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float
from markupsafe import Markup

from experiments.figures.robot_view import (
    BODY_HALF_WIDTH,
    PULLEY,
    PULLEY_HALF_GAP,
    cable_loop,
    shown_instants,
)
from scdpr_jax.robot.parameters import Robot

_RATE = 16.0
"""Poses a second: four a period of a vibration of 4 Hz, and enough for the eye [Hz]."""
_MOST = 200
"""Poses of a film at most: more would make the page heavy."""
_EDGE = 45.0
"""Room about the frame [mm]."""
_CARRIAGE = 14.0
"""Half of a drawn carriage's height [mm]."""
_CABLES = (("alpha", "var(--d-blue)"), ("beta", "var(--d-green)"), ("gamma", "var(--d-purple)"))


@dataclasses.dataclass(frozen=True, eq=False)
class Track:
    """A robot's motion."""

    name: str
    """What it is called."""
    time: Float[np.ndarray, " rows"]
    """Time [s]."""
    position: Float[np.ndarray, "rows 5"]
    r"""Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m]."""


def robot_film(robot: Robot, track: Track, *, name: str, ghost: Track | None = None) -> Markup:
    """A robot's motion as a drawing that can be started, and as a strip of poses.

    Args:
        robot: The robot.
        track: Its motion.
        name: What the drawing's identifiers begin with; every film needs its own.
        ghost: Another motion, whose end-effector is outlined.

    Returns:
        HTML without a script.
    """
    frame = _Frame(robot)
    last = float(track.time[-1])
    count = int(np.clip(_RATE * (last - float(track.time[0])), 2, _MOST))
    instants = np.linspace(float(track.time[0]), last, count)
    spoken = html.escape(_spoken(track, frame), quote=True)
    rules, shapes = [], []
    if ghost is not None:
        own = _at(ghost, instants)
        rules.append(_rule(f"{name}-ghost", [frame.body_transform(q) for q in own]))
        shapes.append(frame.ghost(f' id="{name}-ghost"'))
    for identifier, shape, transforms in frame.moving(_at(track, instants)):
        rules.append(_rule(f"{name}-{identifier}", transforms))
        shapes.append(shape.format(attributes=f' id="{name}-{identifier}"'))
    seconds = last - float(track.time[0])
    style = "\n".join(rules) + (
        f"\n#{name} svg g[id], #{name} svg line[id], #{name} svg path[id] "
        f"{{ animation-duration: {seconds:.3f}s; }}"
    )
    film = (
        f'<div class="film" id="{name}"><style>{style}</style>'
        f'<input type="checkbox" id="{name}-run"><label for="{name}-run">'
        f"<span>▶ play {seconds:.1f} s</span><span>❚❚ pause</span></label>"
        f'<svg viewBox="{frame.box}" role="img" aria-label="{spoken}">'
        f"{frame.still}{_trace(track, frame)}{''.join(shapes)}</svg></div>"
    )
    poses = "".join(_pose(track, frame, float(t)) for t in shown_instants(track.time))
    return Markup(film + f'<div class="strip">{poses}</div>')


def _at(track: Track, instants: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n 5"]:
    columns = [np.interp(instants, track.time, column) for column in track.position.T]
    return np.stack(columns, axis=1)


def _rule(identifier: str, transforms: Sequence[str]) -> str:
    """Keyframes of one moving part."""
    step = 100 / (len(transforms) - 1)
    frames = " ".join(
        f"{place * step:.4g}%{{transform:{transform}}}"
        for place, transform in enumerate(transforms)
    )
    return (
        f"@keyframes {identifier} {{ {frames} }}\n"
        f"#{identifier} {{ animation-name: {identifier}; transform: {transforms[0]}; }}"
    )


def _spoken(track: Track, frame: "_Frame") -> str:
    """What is to be seen of a motion."""
    x, tilt = track.position[:, 0], np.degrees(track.position[:, 1])
    apart = 1e3 * float(np.abs(track.position[:, 2] - track.position[:, 3]).max())
    return (
        f"The robot, {track.name}: its end-effector goes between x {1e3 * x.min():.0f} and "
        f"{1e3 * x.max():.0f} mm of a frame {frame.width:.0f} mm wide, tilts by up to "
        f"{np.abs(tilt).max():.1f}°, and the carriages part by up to {apart:.0f} mm."
    )


def _trace(track: Track, frame: "_Frame") -> str:
    kept = np.linspace(0, len(track.position) - 1, 200).astype(int)
    points = " ".join(
        f"{1e3 * x:.0f},{frame.height - 1e3 * y:.0f}"
        for x, y in track.position[kept][:, [0, 4]]
    )
    return (
        f'<polyline points="{points}" style="fill: none; stroke: var(--d-red)" '
        'vector-effect="non-scaling-stroke"/>'
    )


def _pose(track: Track, frame: "_Frame", instant: float) -> str:
    """The robot at an instant, standing still."""
    position = _at(track, np.array([instant]))
    shapes = "".join(
        shape.format(attributes=f' style="transform: {transforms[0]}"')
        for _, shape, transforms in frame.moving(position)
    )
    tilt = f"{np.degrees(position[0, 1]):.1f}".replace("-", "−")
    words = f"t = {instant:.2f} s, δₑ = {tilt}°"
    return (
        f'<figure><svg viewBox="{frame.box}" role="img" aria-label="The robot at {words}">'
        f"{frame.still}{_trace(track, frame)}{shapes}</svg>"
        f"<figcaption>{words}</figcaption></figure>"
    )


class _Frame:
    """A robot's shapes in millimetres, downwards positive, as a drawing has them."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.width = 1e3 * float(robot.frame.width)
        self.height = 1e3 * float(robot.frame.height)
        self.radius = 1e3 * float(robot.drive.effective_radius)
        low = self.height + self.radius + _EDGE
        self.box = f"{-_EDGE:g} {-_EDGE:g} {self.width + 2 * _EDGE:g} {low + _EDGE:g}"

    @property
    def still(self) -> str:
        """What doesn't move: the frame and the driver pulleys."""
        pulleys = "".join(
            f'<circle cx="{x:.1f}" cy="{self.height:.1f}" r="{self.radius:.1f}" style="fill: '
            'var(--d-band); stroke: var(--ink)" vector-effect="non-scaling-stroke"/>'
            for x in (self.radius, self.width - self.radius)
        )
        return (
            f'<rect width="{self.width:.1f}" height="{self.height:.1f}" style="fill: none; '
            f'stroke: var(--d-grey); stroke-width: 12"/>{pulleys}'
        )

    def body_transform(self, position: Float[np.ndarray, "5"]) -> str:
        """Where the end-effector is."""
        x, tilt, _, _, y = position
        return (
            f"translate({1e3 * x:.1f}px,{self.height - 1e3 * y:.1f}px) rotate({-tilt:.4f}rad)"
        )

    def ghost(self, attributes: str) -> str:
        """The outline of an end-effector."""
        return (
            f'<path{attributes} d="{self._body()}" style="fill: none; stroke: var(--d-red); '
            'stroke-width: 2; stroke-dasharray: 5 3" vector-effect="non-scaling-stroke"/>'
        )

    def moving(
        self, positions: Float[np.ndarray, "n 5"]
    ) -> Iterator[tuple[str, str, list[str]]]:
        """The moving parts: identifier, shape with room for attributes, transforms."""
        loops = [cable_loop(self.robot, position) for position in positions]
        for path, colour in _CABLES:
            for side in (0, 1):
                ends = [1e3 * loop[path][side] for loop in loops]
                yield (
                    f"{path}{side}",
                    f'<line{{attributes}} x2="1" stroke="{colour}" stroke-width="1.6" '
                    'vector-effect="non-scaling-stroke"/>',
                    [self._stretched(*two) for two in ends],
                )
        lower = [f"translate({1e3 * q[2]:.1f}px,{self.height:.1f}px)" for q in positions]
        yield "guide", self._guide(), lower
        carriages = (
            ("lower", 2, self.height, self.robot.lower_carriage),
            ("upper", 3, 0.0, self.robot.upper_carriage),
        )
        for name, column, down, carriage in carriages:
            shape = self._carriage(500.0 * float(carriage.width), lower=name == "lower")
            places = [f"translate({1e3 * q[column]:.1f}px,{down:.1f}px)" for q in positions]
            yield name, f"<g{{attributes}}>{shape}</g>", places
        body = (
            f'<g{{attributes}}><path d="{self._body()}" style="fill: var(--d-body); stroke: '
            'var(--ink)" vector-effect="non-scaling-stroke"/><circle r="9" '
            'style="fill: var(--ink)"/></g>'
        )
        yield "body", body, [self.body_transform(position) for position in positions]

    def _stretched(self, begin: Float[np.ndarray, "2"], end: Float[np.ndarray, "2"]) -> str:
        """From a line of length one along x to one between two points."""
        along, up = end[0] - begin[0], begin[1] - end[1]
        return (
            f"matrix({along:.1f},{up:.1f},{-up:.1f},{along:.1f},{begin[0]:.1f},"
            f"{self.height - begin[1]:.1f})"
        )

    def _guide(self) -> str:
        """The cables along the lower guide, which end at the driver pulleys."""
        radius, gap = self.radius, 1e3 * PULLEY_HALF_GAP
        half = 500.0 * float(self.robot.lower_carriage.width)
        ends = (
            f"M{side * x:.1f} 0V{up:.1f}H{side * 2 * self.width:.1f}"
            for side in (-1, 1)
            for x, up in ((gap, -radius), (half, radius))
        )
        box = (
            f"{radius:.1f} {self.height - radius - 3:.1f} {self.width - 2 * radius:.1f} "
            f"{2 * radius + 6:.1f}"
        )
        x, y, wide, high = box.split()
        return (
            f'<svg x="{x}" y="{y}" width="{wide}" height="{high}" viewBox="{box}">'
            f'<g{{attributes}}><path d="{"".join(ends)}" style="fill: none; stroke: '
            'var(--ink)" vector-effect="non-scaling-stroke"/></g></svg>'
        )

    def _body(self) -> str:
        body, half = self.robot.end_effector, 1e3 * BODY_HALF_WIDTH
        low, high = 1e3 * float(body.lower_offset), 1e3 * float(body.upper_offset)
        return f"M{-half:.1f} {-high:.1f}H{half:.1f}V{low:.1f}H{-half:.1f}Z"

    def _carriage(self, half: float, *, lower: bool) -> str:
        """A carriage with its pulleys."""
        gap = 1e3 * PULLEY_HALF_GAP
        wheels = "".join(
            f'<circle cx="{x:.1f}" r="{1e3 * PULLEY:.1f}" style="fill: var(--paper); stroke: '
            'var(--ink)" vector-effect="non-scaling-stroke"/>'
            for x in (-half, -gap, gap, half)
        )
        plate = (
            f'<rect x="{-half:.1f}" y="{-_CARRIAGE:.1f}" width="{2 * half:.1f}" '
            f'height="{2 * _CARRIAGE:.1f}" style="fill: var(--d-steel); stroke: var(--ink)" '
            'vector-effect="non-scaling-stroke"/>'
        )
        return plate + wheels
