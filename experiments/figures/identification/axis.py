"""A motor-driven axis measured and simulated open loop."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from identification.axis.estimate import DriveAxisEstimate
from identification.axis.log import AxisLog


@style.styled
def axis_figure(log: AxisLog, estimate: DriveAxisEstimate) -> Figure:
    """Position, residual and command of an axis.

    Args:
        log: The log.
        estimate: What was found in it.

    Returns:
        The figure.
    """
    unit = "mm" if log.position_unit == "m" else "mrad"
    time, measured = np.asarray(log.time), 1e3 * np.asarray(log.position)
    simulated = 1e3 * np.asarray(estimate.positions)
    figure = style.new_figure(height=6.4, width=5.0)
    position, residual, command = figure.subplots(
        3, 1, sharex=True, height_ratios=(2, 1.2, 0.9)
    )
    position.plot(
        *style.thinned(time, measured), color=style.BLUE, lw=3.5, alpha=0.5, label="measured"
    )
    position.plot(
        *style.thinned(time, simulated),
        color=style.VERMILION,
        lw=1.2,
        label="simulated, open loop",
    )
    position.set_ylabel(f"position [{unit}]")
    residual.plot(*style.thinned(time, measured - simulated), color=style.BLUE, lw=1.0)
    residual.axhline(0, color=style.GREY, lw=0.6)
    residual.set_ylabel(f"residual [{unit}]")
    command.plot(*style.thinned(time, np.asarray(log.voltage)), color=style.BLUE, lw=1.0)
    command.set(ylabel="command [V]", xlabel="time [s]")
    figure.align_ylabels()
    style.figure_legend(figure, position)
    return figure
