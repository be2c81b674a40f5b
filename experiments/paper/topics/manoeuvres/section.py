"""Sections of Table 3 and Figures 16 to 20."""

import numpy as np

from experiments.page.page import Pictures
from experiments.page.table import table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.manoeuvres.claims import FIG18, FIG19, FIG20, TABLE3
from experiments.paper.topics.manoeuvres.figure import (
    draw_diagonal,
    draw_errors,
    draw_joints,
    draw_tracking,
)
from experiments.paper.topics.manoeuvres.numbers import (
    BOTH_LEGS,
    GRAVITY,
    ONE_LEG,
    Tracked,
    tracked,
)
from scdpr_jax.robot.state import X

_CASES = (
    ("horizontal", ONE_LEG, None, 0.0),
    ("horizontal", BOTH_LEGS, None, 0.0),
    ("horizontal", BOTH_LEGS, 350.0, 0.0),
    ("vertical", ONE_LEG, None, 0.0),
    ("vertical", BOTH_LEGS, None, 0.0),
    ("vertical", BOTH_LEGS, None, GRAVITY),
    ("diagonal", ONE_LEG, None, 0.0),
    ("diagonal", BOTH_LEGS, None, 0.0),
    ("diagonal", ONE_LEG, None, GRAVITY),
)


def _row(name: str, leg_time: float, tension: float | None, gravity: float) -> dict[str, str]:
    run = tracked(name, leg_time, tension, gravity)
    return {
        "manoeuvre": name,
        "a leg [s]": f"{leg_time:g}",
        "T_eff [N]": f"{85 if tension is None else tension:g}",
        "gravity": "on" if gravity else "off",
        "largest error (26) [mm]": f"{1e3 * run.error.max():.1f}",
        "largest rotation [°]": f"{np.rad2deg(run.tilt):.2f}",
        "largest command [V]": f"{np.abs(run.voltage).max():.2f}",
        "error a second after the end [mm]": f"{1e3 * run.error[-1]:.1f}",
    }


def table3(picture: Pictures) -> Content:
    """Every reading of the manoeuvres.

    Args:
        picture: The page's figures; none is drawn.

    Returns:
        The section.
    """
    return Content(
        "Table 3 doesn't say whether its time is that of one leg or of both. The diagonal "
        "asks for one leg (at 1.25 s a leg it would need 20 V), the horizontal manoeuvre "
        "for both: 50 mm come at 2 s a leg, 25 mm at 4 s.",
        "The vertical manoeuvre's 8 mm are 5.7 mm without gravity at 2.25 s a leg and 8.8 "
        "mm with it: a PD holds 20.6 N of weight only with an error of 3 mm. The paper "
        "leaves gravity out.",
        "With the nominal 350 N the horizontal error is 20 mm, not 50.",
        table_of(
            "Table 3 under the printed controller, 4.5 N of friction on each carriage",
            (_row(name, times[name], *case) for name, times, *case in _CASES),
        ),
    )


def _tracking(name: str, picture: Pictures, then: str) -> Content:
    run = tracked(name, BOTH_LEGS[name])
    return Content(
        f"At {run.leg_time:g} s a leg. {then}",
        picture(draw_tracking(run), f"Reference tracking, {name} manoeuvre."),
    )


def _rest(run: Tracked) -> tuple[float, float]:
    """Swing of the end-effector in the last half second, and where it swings about [m]."""
    last = run.time >= run.time[-1] - 0.5
    away = run.position[last, X] - run.reference[last, 0]
    return float(np.ptp(away)), float(np.mean(away))


def fig16(picture: Pictures) -> Content:
    """The horizontal manoeuvre.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    swing, offset = _rest(tracked("horizontal", BOTH_LEGS["horizontal"]))
    return _tracking(
        "horizontal",
        picture,
        "The end-effector vibrates after each start and stop, as the paper notes: a second "
        f"after the end it still swings by {1e3 * swing:.0f} mm, about a place that friction "
        f"keeps {1e3 * abs(offset):.0f} mm from the reference.",
    )


def fig17(picture: Pictures) -> Content:
    """The vertical manoeuvre.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    return _tracking(
        "vertical",
        picture,
        "Nothing vibrates: the height doesn't couple into an aligned pose.",
    )


def errors() -> dict[str, tuple[Tracked, float]]:
    """The runs of Figure 18 with the errors that the paper reports.

    Returns:
        Runs by name, each with the reported largest error [m].
    """
    return {
        "horizontal, 2 s a leg": (tracked("horizontal", BOTH_LEGS["horizontal"]), 50e-3),
        "vertical, 2.25 s a leg, gravity on": (
            tracked("vertical", BOTH_LEGS["vertical"], None, GRAVITY),
            8e-3,
        ),
    }


def fig18(picture: Pictures) -> Content:
    """The errors.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    runs = errors()
    sentences = tuple(
        f"{name}: {1e3 * run.error.max():.1f} mm at the most, where the commanded "
        f"acceleration is {100 * run.pushed:.0f} % of its largest; reported are about "
        f"{1e3 * reported:.0f} mm."
        for name, (run, reported) in runs.items()
    )
    return Content(*sentences, picture(draw_errors(runs), "Tracking error, Eq. (26)."))


def fig19(picture: Pictures) -> Content:
    """The diagonal manoeuvre.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    run = tracked("diagonal", ONE_LEG["diagonal"])
    return Content(
        f"At 2.5 s a leg the rotation is {np.rad2deg(run.tilt):.1f}° at the most, reported "
        "3.2°; the horizontal manoeuvre at 2 s a leg has "
        f"{np.rad2deg(tracked('horizontal', 2.0).tilt):.1f}°.",
        "The table's x = 0.01 m can't be reached: (1) needs 0.1435 m, half a carriage. The "
        "simulation has no walls.",
        picture(draw_diagonal(run), "Diagonal manoeuvre: path, and rotation over time."),
    )


def fig20(picture: Pictures) -> Content:
    """Joints and commands of the diagonal manoeuvre.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    run = tracked("diagonal", ONE_LEG["diagonal"])
    saturated = np.mean(np.abs(run.voltage).max(axis=1) >= 10.0)
    return Content(
        f"The command reaches its limit for {100 * saturated:.0f} % of the time; the paper "
        "calls it near the limit.",
        picture(draw_joints(run, limit=10.0), "Joint angles and commands, diagonal manoeuvre."),
    )


SECTIONS = (
    Section("table3", "Table 3: controlled manoeuvres", 20.0, table3, TABLE3),
    Section("fig16", "Figure 16: horizontal manoeuvre", 1.0, fig16),
    Section("fig17", "Figure 17: vertical manoeuvre", 1.0, fig17),
    Section("fig18", "Figure 18: tracking error", 1.0, fig18, FIG18),
    Section("fig19", "Figure 19: diagonal manoeuvre", 1.0, fig19, FIG19),
    Section("fig20", "Figure 20: joints and control signals", 1.0, fig20, FIG20),
)
"""Sections of this module."""
