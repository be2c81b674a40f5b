"""The robot drawn to scale: frame, carriages, end-effector and the cable loop's path."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle

from experiments.page import style
from scdpr_jax.robot.parameters import Robot

PULLEY = 0.018  # m, radius of a drawn deflection pulley
PULLEY_HALF_GAP = 0.09  # m, half of the distance between the two inner cables
BODY_HALF_WIDTH = 0.1405  # m: half of Table 1's width, which no equation needs


def cable_loop(
    robot: Robot, position: Float[np.ndarray, "5"]
) -> dict[str, list[Float[np.ndarray, "points 2"]]]:
    r"""Where the cables run: two parallel ones on each of the paths alpha, beta and gamma.

    From the clamp below the end-effector each end goes down a path alpha to the lower
    carriage, along the lower guide round the driver pulley in its corner and back, up a
    path gamma to the upper carriage, and down a path beta to the end-effector's top,
    where the two sides meet over a pulley.

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        Polylines [m] by path: `alpha`, `beta`, `gamma`, and `guide` along the lower guide.
    """
    x, tilt, lower, upper, y = position
    body, frame = robot.end_effector, robot.frame
    width, height = float(frame.width), float(frame.height)
    bottom = np.array(
        [
            x + float(body.lower_offset) * np.sin(tilt),
            y - float(body.lower_offset) * np.cos(tilt),
        ]
    )
    top = np.array(
        [
            x - float(body.upper_offset) * np.sin(tilt),
            y + float(body.upper_offset) * np.cos(tilt),
        ]
    )
    across = np.array([np.cos(tilt), np.sin(tilt)]) * PULLEY_HALF_GAP
    outer_low = float(robot.lower_carriage.width) / 2
    outer_high = float(robot.upper_carriage.width) / 2
    radius = _drawn_radius(robot)
    paths: dict[str, list] = {"alpha": [], "beta": [], "gamma": [], "guide": []}
    for side, corner in ((-1, radius), (1, width - radius)):
        inner = np.array([lower + side * PULLEY_HALF_GAP, 0.0])
        outer = np.array([lower + side * outer_low, 0.0])
        above = np.array([upper + side * outer_high, height])
        paths["alpha"].append(np.stack([bottom + side * across, inner]))
        paths["beta"].append(
            np.stack([top + side * across, [upper + side * PULLEY_HALF_GAP, height]])
        )
        paths["gamma"].append(np.stack([outer, above]))
        turn = np.linspace(np.pi / 2, -np.pi / 2, 15)
        round_pulley = np.stack(
            [corner + side * radius * np.cos(turn), radius * np.sin(turn)], axis=1
        )
        ahead = np.array([inner, [inner[0], radius]])
        back = np.array([[outer[0], -radius], outer])
        paths["guide"].append(np.concatenate([ahead, round_pulley, back]))
    return paths


def _drawn_radius(robot: Robot) -> float:
    return float(robot.drive.effective_radius)


def draw_robot(axes: Axes, robot: Robot, position: Float[np.ndarray, "5"]) -> None:
    r"""Draw the robot at a pose into axes in millimetres.

    Args:
        axes: The axes.
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].
    """
    x, tilt, lower, upper, y = (float(number) for number in position)
    width, height = 1e3 * float(robot.frame.width), 1e3 * float(robot.frame.height)
    axes.add_patch(Rectangle((0, 0), width, height, fill=False, edgecolor=style.GREY, lw=3))
    colors = {
        "alpha": style.BLUE,
        "beta": style.GREEN,
        "gamma": style.PURPLE,
        "guide": style.BLACK,
    }
    for name, lines in cable_loop(robot, position).items():
        for line in lines:
            axes.plot(*(1e3 * line.T), color=colors[name], lw=1.3)
    for place, at, carriage in (
        (lower, 0.0, robot.lower_carriage),
        (upper, height, robot.upper_carriage),
    ):
        half = 1e3 * float(carriage.width) / 2
        axes.add_patch(
            Rectangle(
                (1e3 * place - half, at - 14),
                2 * half,
                28,
                facecolor="#d9d9d9",
                edgecolor=style.BLACK,
            )
        )
        for offset in (-half, -1e3 * PULLEY_HALF_GAP, 1e3 * PULLEY_HALF_GAP, half):
            axes.add_patch(
                Circle(
                    (1e3 * place + offset, at),
                    1e3 * PULLEY,
                    facecolor="white",
                    edgecolor=style.BLACK,
                )
            )
    radius = 1e3 * _drawn_radius(robot)
    for corner in (radius, width - radius):
        axes.add_patch(
            Circle((corner, 0), radius, facecolor="#f2f2f2", edgecolor=style.BLACK, lw=1.2)
        )
        axes.plot(corner, 0, "+", color=style.BLACK, ms=6)
    _draw_body(axes, robot, (x, y, tilt))


def _draw_body(axes: Axes, robot: Robot, pose: tuple[float, float, float]) -> None:
    x, y, tilt = pose
    body = robot.end_effector
    low, high = float(body.lower_offset), float(body.upper_offset)
    half = BODY_HALF_WIDTH
    corners = np.array([[-half, -low], [half, -low], [half, high], [-half, high]])
    turn = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
    axes.add_patch(
        Polygon(
            1e3 * (corners @ turn.T + [x, y]),
            facecolor="#cfe3f1",
            edgecolor=style.BLACK,
            lw=1.2,
            zorder=4,
        )
    )
    axes.plot(1e3 * x, 1e3 * y, "o", color=style.BLACK, ms=3, zorder=5)


@style.styled
def robot_view(
    robot: Robot,
    *,
    time: Float[np.ndarray, " rows"],
    path: Float[np.ndarray, "rows 5"],
    instants: Sequence[float],
) -> Figure:
    """The robot at a few instants of a run, with the path of the end-effector.

    Args:
        robot: The robot.
        time: Time [s].
        path: Positions of the run [m, rad, m, m, m].
        instants: When to draw it [s].

    Returns:
        The figure, two panels a row.
    """
    rows = (len(instants) + 1) // 2
    figure, grid = style.panels(rows, 2, sharex=True, sharey=True, height=2.9 * rows)
    trace = 1e3 * path[:: max(1, len(path) // 300)]
    for axes, instant in zip(grid, instants, strict=False):
        row = int(np.argmin(np.abs(time - instant)))
        draw_robot(axes, robot, path[row])
        axes.plot(trace[:, 0], trace[:, 4], color=style.VERMILION, lw=1.4, zorder=6)
        tilt = np.degrees(path[row, 1])
        axes.set(
            title=f"t = {time[row]:.2f} s, δₑ = {tilt:.2f}°".replace("-", "−"), aspect="equal"
        )
        axes.grid(False)
        axes.set(xlabel="x [mm]", ylabel="y [mm]")
        axes.label_outer()
    for axes in grid[len(instants) :]:
        axes.set_axis_off()
    radius = 1e3 * _drawn_radius(robot)
    grid[0].set(
        xlim=(-40, 1e3 * float(robot.frame.width) + 40),
        ylim=(-radius - 25, 1e3 * float(robot.frame.height) + 45),
    )
    return figure


def shown_instants(time: Float[np.ndarray, " rows"]) -> tuple[float, ...]:
    """Four instants of a run that show its course.

    Args:
        time: Time [s].

    Returns:
        Instants [s].
    """
    first, last = float(time[0]), float(time[-1])
    return tuple(first + share * (last - first) for share in (0.05, 0.3, 0.5, 0.75))
