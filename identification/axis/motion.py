r"""Motion of one motor-driven axis with exact Coulomb friction, from its voltage.

$$ M \ddot q + F_v \dot q + F_c \,\mathrm{Sgn}(\dot q) + o \ni g u,
   \qquad \mathrm{Sgn}(0) = [-1, 1] $$

The voltage is held between samples, so each step has a closed form: slide, stop at an
instant inside the step, then stick or slip on in the other direction. There is nothing to
iterate and no smoothing width, and gradients hold through the instants of stopping.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from scdpr_jax.robot.fields import real, si


class AxisParameters(eqx.Module):
    """What an axis resists with; for a rotary axis read kg m², N m s, N m and N m."""

    mass: Float[Array, ""] = eqx.field(converter=real, metadata=si("kg", "M"))
    """Moving mass with the motor's reflected inertia $M$ [kg]."""
    viscous: Float[Array, ""] = eqx.field(converter=real, metadata=si("N s/m", "F_v"))
    """Viscous friction $F_v$ [N s/m]."""
    coulomb: Float[Array, ""] = eqx.field(converter=real, metadata=si("N", "F_c"))
    """Coulomb friction $F_c$ [N]."""
    offset: Float[Array, ""] = eqx.field(converter=real, metadata=si("N", "o"))
    """Force that the voltage has to overcome besides, of either direction, $o$ [N]."""
    viscous_difference: Float[Array, ""] = eqx.field(
        default=0.0, converter=real, metadata=si("N s/m", r"\Delta F_v")
    )
    r"""Viscous friction forwards minus that backwards $\Delta F_v$ [N s/m]."""

    def viscous_along(self, direction: Float[Array, ""]) -> Float[Array, ""]:
        """Viscous friction in a direction, +1 or -1; their mean at 0 [N s/m]."""
        return self.viscous + direction * self.viscous_difference / 2


class AxisState(eqx.Module):
    """Where an axis is and how fast it moves."""

    position: Float[Array, ""] = eqx.field(converter=real, metadata=si("m", "q"))
    """Position $q$ [m]."""
    velocity: Float[Array, ""] = eqx.field(converter=real, metadata=si("m/s", r"\dot q"))
    r"""Velocity $\dot q$ [m/s], exactly 0 where it sticks."""


def axis_positions(
    parameters: AxisParameters,
    force: Float[Array, " steps"],
    *,
    steps: Float[Array, " steps"],
    start: Float[Array, ""],
    velocity: Float[Array, ""] | float = 0.0,
) -> Float[Array, " steps+1"]:
    """Open-loop positions of an axis.

    Args:
        parameters: The axis.
        force: Force of the drive, held over each step [N].
        steps: Durations of the steps [s].
        start: Position at the beginning [m].
        velocity: Velocity at the beginning [m/s].

    Returns:
        Positions at the beginning and after each step [m].
    """

    def advance(
        state: AxisState, inputs: tuple[Float[Array, ""], Float[Array, ""]]
    ) -> tuple[AxisState, Float[Array, ""]]:
        state = axis_step(parameters, state, force=inputs[0], duration=inputs[1])
        return state, state.position

    begun = AxisState(position=start, velocity=velocity + jnp.zeros_like(start))
    _, positions = jax.lax.scan(advance, begun, (force, steps))
    return jnp.concatenate([start[None], positions])


class Restarts(eqx.Module):
    """Where a simulation is put back to what was measured."""

    here: Bool[Array, "*batch samples"]
    """Whether it is put back at a sample; the first one counts as such."""
    position: Float[Array, "*batch samples"] = eqx.field(metadata=si("m", "q"))
    """Position that it then has [m]."""
    velocity: Float[Array, "*batch samples"] = eqx.field(metadata=si("m/s", r"\dot q"))
    """Velocity that it then has [m/s]."""


def restarted_positions(
    parameters: AxisParameters,
    force: Float[Array, " steps"],
    *,
    steps: Float[Array, " steps"],
    restarts: Restarts,
) -> Float[Array, " steps+1"]:
    """Positions of an axis that is simulated anew from some samples on.

    Args:
        parameters: The axis.
        force: Force of the drive, held over each step [N].
        steps: Durations of the steps [s].
        restarts: Where it is put back to what was measured.

    Returns:
        Positions at the samples [m].
    """

    def advance(
        state: AxisState, inputs: tuple[Array, Array, Array, Array, Array]
    ) -> tuple[AxisState, Float[Array, ""]]:
        force, duration, here, position, velocity = inputs
        state = axis_step(parameters, state, force=force, duration=duration)
        state = AxisState(
            position=jnp.where(here, position, state.position),
            velocity=jnp.where(here, velocity, state.velocity),
        )
        return state, state.position

    begun = AxisState(restarts.position[0], restarts.velocity[0])
    later = (restarts.here[1:], restarts.position[1:], restarts.velocity[1:])
    _, positions = jax.lax.scan(advance, begun, (force, steps, *later))
    return jnp.concatenate([begun.position[None], positions])


def axis_step(
    parameters: AxisParameters,
    state: AxisState,
    *,
    force: Float[Array, ""],
    duration: Float[Array, ""],
) -> AxisState:
    r"""State after a step of constant force: slide, stop, then stick or slip back.

    Sliding in direction $s$ from $v_0$, with $f = g u - o$ and $\lambda = F_v / M$:

    $$ v(t) = v_0 + A t\, \varphi_1(-\lambda t), \quad
       q(t) = q_0 + v_0 t + A t^2 \varphi_2(-\lambda t), \quad
       A = (f - s F_c - F_v v_0) / M $$

    Args:
        parameters: The axis.
        state: State at the beginning of the step.
        force: Force of the drive $g u$ over the step [N].
        duration: Length of the step [s].

    Returns:
        State at its end.
    """
    M, F_c = parameters.mass, parameters.coulomb
    f = force - parameters.offset
    q, v = state.position, state.velocity
    s = jnp.sign(v)
    F_v = parameters.viscous_along(s)

    sliding_time, halts = _sliding_time(M, F_v, v, load=f - s * F_c, duration=duration)
    move, gain = _glide(sliding_time, v, start_rate=(f - s * F_c - F_v * v) / M, decay=F_v / M)
    q, v = q + move, jnp.where(halts, 0.0, v + gain)

    # At a standstill the friction holds up to F_c; beyond that it slips on along the force.
    remaining = duration - sliding_time
    slips = halts & (jnp.abs(f) > F_c)
    surplus = f - jnp.sign(f) * F_c
    decay = parameters.viscous_along(jnp.sign(f)) / M
    move, gain = _glide(remaining, jnp.zeros_like(v), start_rate=surplus / M, decay=decay)
    return AxisState(
        position=q + jnp.where(slips, move, 0.0), velocity=jnp.where(slips, gain, v)
    )


def _sliding_time(
    mass: Float[Array, ""],
    viscous: Float[Array, ""],
    velocity: Float[Array, ""],
    *,
    load: Float[Array, ""],
    duration: Float[Array, ""],
) -> tuple[Float[Array, ""], Array]:
    r"""Time until the axis stops, at most the step, and whether it does.

    $$ t^* = -\frac{M v_0}{p} \frac{\ln(1 + w)}{w}, \quad w = -\frac{F_v v_0}{p}, \quad
       p = f - s F_c $$
    """
    moves = velocity != 0
    braked = velocity * load < 0
    # Where nothing brakes there is no such time: a harmless one keeps the gradient finite.
    p = jnp.where(braked, load, 1.0)
    v = jnp.where(braked, velocity, 0.0)
    w = jnp.where(braked, -viscous * v / p, 0.0)
    stop = -mass * v / p * _log1p_ratio(w)
    halts = ~moves | (braked & (stop < duration))
    until = jnp.where(moves, jnp.where(halts, stop, duration), 0.0)
    return until, halts


def _glide(
    time: Float[Array, ""],
    velocity: Float[Array, ""],
    *,
    start_rate: Float[Array, ""],
    decay: Float[Array, ""],
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Way [m] and gain of velocity [m/s] after a time of sliding in one direction."""
    first, second = _phi(-decay * time)
    return time * (velocity + start_rate * time * second), start_rate * time * first


def _phi(z: Float[Array, ""]) -> tuple[Float[Array, ""], Float[Array, ""]]:
    r"""$\varphi_1(z) = (e^z - 1)/z$ and $\varphi_2(z) = (e^z - 1 - z)/z^2$, smooth at 0."""
    small = jnp.abs(z) < 0.1
    near = jnp.where(small, z, 0.0)
    # Ten terms leave 0.1^10/12! < 1e-18 out; beyond 0.1 the cancellation costs 20 eps.
    series = jnp.zeros_like(z)
    for k in range(11, 1, -1):
        series = (1.0 + near * series) / k
    far = jnp.where(small, 1.0, z)
    second = jnp.where(small, series, (jnp.expm1(far) - far) / far**2)
    return 1.0 + z * second, second


def _log1p_ratio(w: Float[Array, ""]) -> Float[Array, ""]:
    r"""$\ln(1 + w) / w$, smooth at 0."""
    small = jnp.abs(w) < 1e-4
    near = jnp.where(small, w, 0.0)
    # Four terms leave w^4/5 < 2e-17 out.
    series = 1.0 - near * (1 / 2 - near * (1 / 3 - near / 4))
    far = jnp.where(small, 1.0, w)
    return jnp.where(small, series, jnp.log1p(far) / far)
