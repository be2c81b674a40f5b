"""A made-up axis: no fit, numbers known beforehand."""

import dataclasses

import jax.numpy as jnp
import numpy as np

from identification.axis.estimate import EXTENDED_NAMES, DriveAxisEstimate
from identification.axis.law import AxisLaws
from identification.axis.log import AxisLog
from identification.axis.motion import AxisParameters


def axis():
    time = np.arange(100) * 0.01
    log = AxisLog(time, np.sin(time), 0.1 * np.sin(time))
    found = DriveAxisEstimate(
        parameters=AxisParameters(95.1, 203.5, 20.3, -3.2),
        sigma=AxisParameters(0.5, 2.0, 0.2, 0.1),
        interval95=jnp.array([[94.1, 96.1], [199.6, 207.4], [19.9, 20.7], [-3.4, -3.0]]),
        correlation=jnp.eye(4),
        status=("identified", "identified", "weak", "identified"),
        open_loop_rmse=1.2e-3,
        positions=log.position + 1.2e-3,
        memory=0.4,
        starts=6,
        agreeing_starts=5,
        iterations=20,
        converged=True,
    )
    return log, found


def laws(found, *, ahead):
    extended = dataclasses.replace(
        found,
        parameters=AxisParameters(93.5, 195.4, 21.3, 0.1, -83.0),
        sigma=AxisParameters(0.5, 2.0, 0.2, 0.1, 4.0),
        interval95=jnp.concatenate([found.interval95, jnp.array([[-90.8, -75.2]])]),
        correlation=jnp.eye(5),
        status=(*found.status, "identified"),
        names=EXTENDED_NAMES,
    )
    return AxisLaws(found, extended, 7e-3, ahead, open_loop_ahead=8e-3)
