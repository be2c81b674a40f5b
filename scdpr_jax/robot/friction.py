r"""Friction of a passive carriage on its guide, Eqs. (7), (8) and (21).

A law turns a sliding velocity and a normal force into a friction force. Its dry part is the
normal force times a coefficient, which may be higher near standstill, and against the
velocity; exact and smoothed laws differ in what happens where the velocity turns round.

Reference: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, "A survey of models, analysis
tools and compensation methods for the control of machines with friction", Automatica 30(7),
1994, doi:10.1016/0005-1098(94)90209-7.
"""

import abc

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.robot.fields import real, si

STRIBECK_VELOCITY = 0.02
"""Velocity over which a static surplus decays unless another one is given [m/s]."""


class Friction(eqx.Module):
    """A friction law of a carriage."""

    coefficient: eqx.AbstractVar[Float[Array, "..."]]
    r"""Kinetic coefficient of friction $\mu$ [1]."""

    viscous: eqx.AbstractVar[Float[Array, "..."]]
    """Viscous damping beside the dry friction [N s/m]."""

    static_surplus: eqx.AbstractVar[Float[Array, "..."]]
    r"""By how much the coefficient is higher at standstill, $\mu_s - \mu$ [1]."""

    stribeck_velocity: eqx.AbstractVar[Float[Array, "..."]]
    """Velocity $v_{st}$ over which that decays [m/s], positive."""

    @abc.abstractmethod
    def dry(
        self, velocity: Float[Array, ""], normal_force: Float[Array, ""]
    ) -> Float[Array, ""]:
        """Dry friction force along the velocity, to be subtracted from the balance.

        Args:
            velocity: Sliding velocity [m/s].
            normal_force: Normal force on the guide [N].

        Returns:
            Dry friction force [N], of the velocity's sign; the viscous part is apart.
        """

    def sliding(self, velocity: Float[Array, "..."]) -> Float[Array, "..."]:
        r"""Coefficient of friction at a velocity, the static one at standstill.

        $$ \mu + (\mu_s - \mu)\, e^{-(v/v_{st})^2} $$

        Args:
            velocity: Sliding velocity [m/s].

        Returns:
            The coefficient [1].
        """
        decay = jnp.exp(-jnp.square(velocity / self.stribeck_velocity))
        return self.coefficient + self.static_surplus * decay


class Coulomb(Friction):
    r"""Exact (set-valued) dry friction, Eq. (21).

    $$ F \in \mu(v) N \,\mathrm{Sgn}(v) + d v, \qquad \mathrm{Sgn}(0) = [-1, 1] $$

    At standstill the friction is whatever holds the carriage, up to $\mu_s N$. `dry`
    gives the sliding branch, and 0 at standstill; `scdpr_jax.engines.stepping` resolves the
    set.
    """

    coefficient: Float[Array, "..."] = eqx.field(converter=real, metadata=si("1", r"\mu"))
    r"""Kinetic coefficient of friction $\mu$ [1]."""
    viscous: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("N s/m", "d")
    )
    """Viscous damping [N s/m]."""
    static_surplus: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("1", r"\Delta\mu")
    )
    stribeck_velocity: Float[Array, "..."] = eqx.field(
        default=STRIBECK_VELOCITY, converter=real, metadata=si("m/s", "v_{st}")
    )

    def dry(
        self, velocity: Float[Array, ""], normal_force: Float[Array, ""]
    ) -> Float[Array, ""]:
        return self.sliding(velocity) * normal_force * jnp.sign(velocity)


class SmoothCoulomb(Friction):
    r"""Dry friction with its jump spread over a velocity width.

    $$ F = \mu(v) N \tanh(v / v_s) + d v $$

    A carriage on it creeps instead of sticking. The bias against exact Coulomb friction
    falls in proportion to the width: 1.7 mm at 1e-2 m/s, 0.30 mm at 1e-3 and 36 µm at
    1e-4 in the torque step that `docs/validity.md` describes.
    """

    coefficient: Float[Array, "..."] = eqx.field(converter=real, metadata=si("1", r"\mu"))
    r"""Kinetic coefficient of friction $\mu$ [1]."""
    width: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m/s", "v_s"))
    """Velocity $v_s$ over which the friction turns round [m/s], positive."""
    viscous: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("N s/m", "d")
    )
    """Viscous damping [N s/m]."""
    static_surplus: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("1", r"\Delta\mu")
    )
    stribeck_velocity: Float[Array, "..."] = eqx.field(
        default=STRIBECK_VELOCITY, converter=real, metadata=si("m/s", "v_{st}")
    )

    def dry(
        self, velocity: Float[Array, ""], normal_force: Float[Array, ""]
    ) -> Float[Array, ""]:
        return self.sliding(velocity) * normal_force * jnp.tanh(velocity / self.width)
