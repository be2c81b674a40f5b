"""Sampled joint controllers of section 6.1, and the saturation of their command."""

import abc
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PyTree

from scdpr_jax.robot.fields import concrete, real, refuse, si

_DEGREES_PER_RADIAN = 180 / jnp.pi


class Controller(eqx.Module):
    """A joint controller, run once a sample period with its state handed through."""

    period: eqx.AbstractVar[Float[Array, "..."]]
    """Sample period [s]."""

    @abc.abstractmethod
    def initial_state(
        self, reference_angles: Float[Array, "2"], measured_angles: Float[Array, "2"]
    ) -> PyTree:
        """State of a controller switched on at rest.

        Args:
            reference_angles: Commanded angles of the driver pulleys [rad].
            measured_angles: Measured angles of the driver pulleys [rad].

        Returns:
            The state to hand to the first `step`.
        """

    @abc.abstractmethod
    def step(
        self,
        state: PyTree,
        reference_angles: Float[Array, "2"],
        measured_angles: Float[Array, "2"],
    ) -> tuple[PyTree, Float[Array, "2"]]:
        """One sample of the controller.

        Args:
            state: State that the step before returned.
            reference_angles: Commanded angles of the driver pulleys at this sample [rad].
            measured_angles: Measured angles of the driver pulleys at this sample [rad].

        Returns:
            The next state, and the command before saturation [V].
        """


class PDState(eqx.Module):
    """What a PD controller remembers from one sample to the next."""

    error: Float[Array | np.ndarray, "... 2"] = eqx.field(metadata=si("rad", r"\varepsilon"))
    """Error of the sample before [rad]."""
    derivative: Float[Array | np.ndarray, "... 2"] = eqx.field(
        metadata=si("rad/s", r"\dot\varepsilon")
    )
    """Its filtered derivative [rad/s]."""


def _positive_period(value: Any) -> Float[Array, "..."]:
    period = real(value)
    message = (
        "`period` of a controller must be positive [s], got one that isn't: "
        "the paper's loop runs at 1e-3 s."
    )
    return refuse(period, ~(concrete(period) > 0), message)


class PD(Controller):
    r"""The PD control law of Eq. (23), one for each actuator, sampled.

    $$ V_i = K_p \varepsilon_i + K_d d_i, \qquad
       d_i = \frac{\tau d_i^- + \varepsilon_i - \varepsilon_i^-}{\tau + h} $$

    The derivative is the backward difference over the sample period $h$. A filter time
    $\tau$ above zero smooths it (the implicit Euler form of $s / (1 + \tau s)$): one encoder
    count in one period is a step of $2\pi / (h N)$ rad/s.
    """

    proportional_gain: Float[Array, "..."] = eqx.field(
        converter=real, metadata=si("V/rad", "K_p")
    )
    """Proportional gain $K_p$ [V/rad]."""
    derivative_gain: Float[Array, "..."] = eqx.field(
        converter=real, metadata=si("V s/rad", "K_d")
    )
    """Derivative gain $K_d$ [V s/rad]."""
    period: Float[Array, "..."] = eqx.field(
        default=1e-3, converter=_positive_period, metadata=si("s", "h")
    )
    """Sample period $h$ [s]."""
    filter_time: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("s", r"\tau")
    )
    r"""Time constant $\tau$ of the derivative's filter [s], 0 for none."""

    @classmethod
    def from_degrees(
        cls,
        proportional_gain: Any,
        derivative_gain: Any,
        *,
        period: Any = 1e-3,
        filter_time: Any = 0.0,
    ) -> "PD":
        """The controller of gains that act on degrees, as the paper's do.

        Args:
            proportional_gain: Proportional gain [V/deg].
            derivative_gain: Derivative gain [V s/deg].
            period: Sample period [s].
            filter_time: Time constant of the derivative's filter [s].

        Returns:
            The same controller in radians.
        """
        return cls(
            real(proportional_gain) * _DEGREES_PER_RADIAN,
            real(derivative_gain) * _DEGREES_PER_RADIAN,
            period,
            filter_time,
        )

    def initial_state(
        self, reference_angles: Float[Array, "2"], measured_angles: Float[Array, "2"]
    ) -> PDState:
        error = reference_angles - measured_angles
        return PDState(error=error, derivative=jnp.zeros_like(error))

    def step(
        self,
        state: PDState,
        reference_angles: Float[Array, "2"],
        measured_angles: Float[Array, "2"],
    ) -> tuple[PDState, Float[Array, "2"]]:
        error = reference_angles - measured_angles
        kept = self.filter_time * state.derivative
        derivative = (kept + error - state.error) / (self.filter_time + self.period)
        voltage = self.proportional_gain * error + self.derivative_gain * derivative
        return PDState(error=error, derivative=derivative), voltage


def published_pd() -> PD:
    """The controller of Eq. (25), $R(s) = 0.6352 + 0.0125 s$, at 1 kHz.

    Printed without units; with the plant of Eq. (24) in degrees its gains are in V/deg
    and V s/deg: see `docs/errata.md`.

    Returns:
        The controller in radians: 36.39 V/rad and 0.7162 V s/rad.
    """
    return PD.from_degrees(0.6352, 0.0125)


def saturate(voltage: Float[Array, "2"], limit: Float[Array, ""]) -> Float[Array, "2"]:
    r"""The command within the servo-amplifier's range.

    $$ \mathrm{sat}(V) = \max(-V_{max}, \min(V, V_{max})) $$

    The clip is exact. Its derivative in the voltage is 1 up to and including the limit and
    0 beyond it: a sample in saturation says nothing about the gains, only about the limit.

    Args:
        voltage: Command of both drives [V].
        limit: Largest command $V_{max}$ of either sign [V].

    Returns:
        What the servo-amplifiers take [V].
    """
    return jnp.where(jnp.abs(voltage) <= limit, voltage, jnp.sign(voltage) * limit)
