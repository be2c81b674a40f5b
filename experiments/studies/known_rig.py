"""What `parameters.json` knows of a rig, as the design of an experiment takes it."""

import math
from collections.abc import Sequence

import numpy as np

from identification.campaign.types import Sensors
from identification.fit.comparison import CAMERA, ENCODERS
from identification.fit.misfit import ERROR_TIME
from identification.fit.unknowns.unknowns import PER_SETTING, encode
from identification.judge.uncertainty import ParameterEstimate, magnitude
from identification.next_run.expected_information import FRAME_RATE, Rig, rig_errors
from identification.result.fitted_robot import FittedRobot, Residual
from scdpr_jax.legs.draws import root_of
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import quantity

UNTOLD = math.log(2)
"""Standard error over the size that stands for one that nothing tells [1]: a factor of 2."""


def known_rig(
    fitted: FittedRobot, *, setting: str | None, log_rate: float, top_speed: float
) -> Rig:
    """What a fit knows of a rig at one pretension.

    Args:
        fitted: What `scdpr identify` wrote.
        setting: The nominal pretension, "350 N"; None for the first one known.
        log_rate: Rate of the logs [Hz].
        top_speed: Largest speed of the end-effector [m/s].

    Returns:
        The rig; what belongs to other settings is left unknown, as it is.

    Raises:
        ValueError: If nothing was estimated, or the setting isn't known.
    """
    rows = fitted.estimated
    if not rows or fitted.correlation is None:
        raise ValueError(
            f"the parameters' uncertainty isn't known, got {len(rows)} estimated parameters "
            "and no correlation of that size. Give a parameters.json that `scdpr identify` "
            "wrote."
        )
    label = setting or next((row.setting for row in rows if row.name == PER_SETTING), None)
    robot = fitted.of_setting(label) if label else fitted.robot
    # What its bound stops was taken for known in the errors of the others.
    at = [
        k
        for k, row in enumerate(rows)
        if row.status != "at_bound"
        and (row.name != PER_SETTING or row.setting in (label, None))
    ]
    kept = [rows[k] for k in at]
    sigma = np.array([_spread(row) for row in kept])
    correlation = fitted.correlation[np.ix_(at, at)]
    noise = _typical([r for r in fitted.residuals if r.channel in ENCODERS], "noise_sigma")
    return Rig(
        robot=robot,
        names=tuple(row.name for row in kept),
        point=np.array([encode(row.name, row.value) for row in kept]),
        root=root_of(correlation * np.outer(sigma, sigma)),
        count=math.sqrt(12) * (noise or Sensors().encoder_sigma),
        log_rate=log_rate,
        top_speed=top_speed,
        **rig_errors(errors(fitted.residuals, log_rate)),
    )


def errors(left: Sequence[Residual], log_rate: float) -> Sensors:
    """What a prediction will be off by, as noise of each sensor.

    Where a fit leaves more than noise the model errs, and for as long as
    `identification.fit.misfit.ERROR_TIME`: what it leaves then counts once in that time.

    Args:
        left: What the fit leaves of each channel.
        log_rate: Rate of the logs [Hz].

    Returns:
        Standard deviations of noise that is worth as much.
    """

    def error(channels: Sequence[str], usual: float, rate: float) -> float:
        own = [one for one in left if one.channel in channels]
        noise = _typical(own, "noise_sigma") or usual
        if all(one.is_noise for one in own):
            return noise
        return max(noise, _typical(own, "rms") * math.sqrt(rate * ERROR_TIME))

    usual, places = Sensors(), (*CAMERA[:1], *CAMERA[2:])
    return Sensors(
        encoder_sigma=error(ENCODERS, usual.encoder_sigma, log_rate),
        camera_position_sigma=error(places, usual.camera_position_sigma, FRAME_RATE),
        camera_angle_sigma=error(CAMERA[1:2], usual.camera_angle_sigma, FRAME_RATE),
    )


def caution(left: Sequence[Residual]) -> str:
    """What the predictions rest on.

    Args:
        left: What the fit leaves of each channel.

    Returns:
        A sentence.
    """
    if all(one.is_noise for one in left):
        return "Predicted for sensors as noisy as in the earlier runs, and a model that fits."
    return (
        "The fit leaves more than noise. The prediction counts what it leaves as an error "
        f"that stands for {ERROR_TIME:g} s; how far another run departs from the model it "
        "can't know."
    )


def poses(robot: Robot) -> tuple[tuple[float, float], ...]:
    """Where a proposed run may start: left, and low and high in the middle.

    Args:
        robot: The robot.

    Returns:
        Poses of the end-effector [m].
    """
    width, height = float(robot.frame.width), float(robot.frame.height)
    shares = ((0.15, 0.5), (0.5, 0.35), (0.5, 0.65))
    return tuple((x * width, y * height) for x, y in shares)


def _typical(left: Sequence[Residual], name: str) -> float:
    """Median of a column; 0 without any."""
    return float(np.median([getattr(one, name) for one in left])) if left else 0.0


def _spread(row: ParameterEstimate) -> float:
    """Standard error of a quantity as a fit holds it."""
    size = row.value if quantity(row.name).positive else 1.0
    if 0 < row.sigma < math.inf:
        return row.sigma / size
    return UNTOLD * magnitude(row.name, row.value) / size
