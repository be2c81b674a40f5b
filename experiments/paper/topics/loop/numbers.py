"""Equations (24) and (25): the drive from a step response, and the gains from it."""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import scipy.optimize
from jaxtyping import Complex, Float

from identification.axis.motion import AxisParameters, axis_positions
from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.sensors import Encoder, read_encoder
from scdpr_jax.robot.drive import transfer_function
from scdpr_jax.robot.parameters import Drive
from scdpr_jax.robot.prototype import consistent
from tuning.loop.loop_shaping import shape_loop
from tuning.loop.margins import Margins, continuous_margins, sampled_margins
from tuning.loop.plant import MotorPlant, published_plant

CROSSOVER, PHASE_MARGIN = 40.0, 60.0
"""Requirements of section 6.1 [rad/s, degrees]."""

STEP = 4.0
"""Command of the step [V]; none is printed."""

_PERIOD, _SAMPLES = 1e-3, 600


class StepResponse(NamedTuple):
    """A bare drive's answer to a step of its command."""

    time: Float[np.ndarray, " samples"]
    """Time [s]."""
    speed: Float[np.ndarray, " samples"]
    """Speed from the encoder over ten samples [deg/s]."""
    fitted: Float[np.ndarray, " samples"]
    """Speed of the fitted transfer function [deg/s]."""
    gain: float
    """Numerator of (24), fitted to the encoder's angle [deg/s²/V]."""
    pole: float
    """Pole of (24), fitted [1/s]."""
    error: tuple[float, float]
    """Standard errors of both."""


@functools.cache
def step_response() -> StepResponse:
    """A bare drive under a step of its command, read by its encoder, and (24) fitted to it.

    Returns:
        The response.
    """
    drive = consistent().drive
    angle = np.rad2deg(np.asarray(_measured_angle(drive)))
    time = _PERIOD * np.arange(_SAMPLES + 1)

    def angle_of(
        t: Float[np.ndarray, " n"], gain: float, pole: float
    ) -> Float[np.ndarray, " n"]:
        return gain * STEP / pole * (t + np.expm1(-pole * t) / pole)

    # An encoder's rounding, a uniform error of one count.
    sigma = 360 / float(Encoder().counts_per_rev) / 12**0.5
    (gain, pole), covariance = scipy.optimize.curve_fit(
        angle_of, time, angle, p0=(1000.0, 10.0), sigma=np.full_like(time, sigma)
    )
    coarse = time[::10]
    return StepResponse(
        time=(coarse[1:] + coarse[:-1]) / 2,
        speed=np.diff(angle[::10]) / (10 * _PERIOD),
        fitted=np.diff(angle_of(coarse, gain, pole)) / (10 * _PERIOD),
        gain=float(gain),
        pole=float(pole),
        error=tuple(np.sqrt(np.diag(covariance)).tolist()),
    )


@jax.jit
def _measured_angle(drive: Drive) -> Float[jax.Array, " samples"]:
    bare = AxisParameters(drive.inertia, drive.damping, drive.friction, jnp.zeros(()))
    torque = jnp.full(_SAMPLES, STEP) * drive.torque_per_volt
    steps = jnp.full(_SAMPLES, _PERIOD)
    angles = axis_positions(bare, torque, steps=steps, start=jnp.zeros(()))
    # The sensor is a pair of encoders; the bare drives turn alike.
    both = jnp.stack([angles, angles], axis=1)
    return jax.vmap(lambda pair: read_encoder(Encoder(), pair))(both)[:, 0]


class Design(NamedTuple):
    """A controller with the margins of its loop."""

    controller: PD
    """The controller."""
    continuous: Margins
    """Margins of the loop that (25) was designed on."""
    sampled: Margins
    """Margins at 1 kHz, the command one sample late."""

    @property
    def gains_in_degrees(self) -> tuple[float, float]:
        """Proportional and derivative gain [V/deg, V s/deg]."""
        gains = (self.controller.proportional_gain, self.controller.derivative_gain)
        return tuple(float(gain) * np.pi / 180 for gain in gains)


@functools.cache
def designed(gain: float = 2169.0, pole: float = 16.68) -> Design:
    """The controller that the requirements ask for, in closed form.

    Args:
        gain: Numerator of (24) [deg/s²/V].
        pole: Pole of (24) [1/s].

    Returns:
        The design.
    """
    plant = MotorPlant(gain=np.deg2rad(gain), pole=pole)
    controller = shape_loop(plant, crossover=CROSSOVER, phase_margin=np.deg2rad(PHASE_MARGIN))
    return _design(plant, controller)


@functools.cache
def printed() -> Design:
    """The printed controller (25) on the printed plant (24).

    Returns:
        The design.
    """
    return _design(published_plant(), published_pd())


def _design(plant: MotorPlant, controller: PD) -> Design:
    return Design(controller, *_margins(plant, controller))


@eqx.filter_jit
def _margins(plant: MotorPlant, controller: PD) -> tuple[Margins, Margins]:
    return continuous_margins(plant, controller), sampled_margins(plant, controller)


def open_loop(
    controller: PD, omega: Float[np.ndarray, " points"]
) -> Complex[np.ndarray, " points"]:
    """Frequency response of the drive (24) with a controller.

    Args:
        controller: The controller.
        omega: Angular frequencies [rad/s].

    Returns:
        The open loop [1].
    """
    plant, s = published_plant(), 1j * omega
    gains = float(controller.proportional_gain) + float(controller.derivative_gain) * s
    return gains * float(plant.gain) / (s * (s + float(plant.pole)))


def gain_from_table() -> float:
    r"""Numerator of (24) from Table 1, $(180/\pi) k_v / J$.

    Returns:
        Gain [deg/s²/V].
    """
    return float(transfer_function(consistent().drive).gain_in_degrees)
