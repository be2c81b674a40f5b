"""Convex minimax problems over phasors, by an interior-point method."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

_SHRINK = 0.1
_CENTRED = 1e-2
_MOST_STEPS = 250
_STEP_SIZES = 24


class Minimax(eqx.Module):
    r"""Residuals whose largest weighted sum is to be made least, over a polytope.

    $$ \min_x \max_g \sum_k W_{gk} \max(|z_k + (J x)_k| - \tau_k,\, 0), \qquad
       l \le x \le h, \quad a \cdot x = b $$

    A modulus of an affine phasor is convex, so is all of this: a minimum is the minimum.
    """

    offset: Float[Array, "2 points"]
    """Both parts of the phasors $z$ at x = 0 [1]."""
    slope: Float[Array, "2 points unknowns"]
    """Their derivative $J$ [1 over the unknown's unit]."""
    tolerated: Float[Array, " points"]
    r"""Moduli $\tau$ that cost nothing [1], not negative."""
    weights: Float[Array, "groups points"]
    """Weights $W$ [1], not negative."""
    lower: Float[Array, " unknowns"]
    """Lower ends $l$ of the unknowns."""
    upper: Float[Array, " unknowns"]
    """Upper ends $h$, all above the lower ones."""
    balance: Float[Array, " unknowns"]
    """Coefficients $a$ of what is conserved; zeros for nothing."""

    def value(self, x: Float[Array, " unknowns"]) -> Float[Array, ""]:
        """The largest weighted sum at a point."""
        return jnp.max(self.weights @ jnp.maximum(self.size(x) - self.tolerated, 0))

    def size(self, x: Float[Array, " unknowns"]) -> Float[Array, " points"]:
        """Moduli of the phasors at a point."""
        return jnp.sqrt(jnp.sum(jnp.square(self.offset + self.slope @ x), axis=0))


class Minimum(NamedTuple):
    """Where a minimax problem has its minimum."""

    x: Float[Array, " unknowns"]
    """The point."""
    value: Float[Array, ""]
    """The objective there [1]."""
    lower_bound: Float[Array, ""]
    """What no point can be below [1], up to the method's centring."""
    converged: Bool[Array, ""]
    """Whether the bound was brought to within the gap asked for."""


class _Point(NamedTuple):
    x: Float[Array, " unknowns"]
    s: Float[Array, " points"]
    u: Float[Array, ""]


class _State(NamedTuple):
    point: _Point
    mu: Float[Array, ""]
    steps: Int[Array, ""]
    done: Bool[Array, ""]


@jax.jit
def minimise(
    problem: Minimax, start: Float[Array, " unknowns"], gap: Float[Array, ""]
) -> Minimum:
    r"""Solve a minimax problem.

    With slacks $s_k \ge \max(|z_k| - \tau_k, 0)$ and a bound $u \ge (W s)_g$ it is a
    second-order cone program. Newton's method follows the central path of its logarithmic
    barrier; on it the objective is within $\nu\mu$ of the minimum, $\nu$ the number of
    barriers.

    Args:
        problem: The problem.
        start: A point strictly inside the bounds; what it conserves is conserved.
        gap: How close to the minimum to come [1].

    Returns:
        The minimum.

    Reference: S. Boyd, L. Vandenberghe, "Convex Optimization", Cambridge 2004, chapter 11,
    doi:10.1017/CBO9780511804441.
    """
    _, points, unknowns = problem.slope.shape
    groups = problem.weights.shape[0]
    barriers = 3 * points + groups + 2 * unknowns
    s = jnp.maximum(problem.size(start) - problem.tolerated, 0) + 0.1
    u = 1.1 * jnp.max(problem.weights @ s) + 0.01
    first = _State(_Point(start, s, u), u / barriers, jnp.asarray(0), jnp.asarray(False))

    def follow(state: _State) -> _State:
        step, decrement = _newton_step(problem, state.point, state.mu)
        moved, advanced = _searched(problem, state.point, step, state.mu)
        # Where rounding leaves no descent the point is as centred as it gets.
        centred = (decrement < _CENTRED) | ~advanced
        last = barriers * state.mu < gap
        point = jax.tree.map(lambda old, new: jnp.where(centred, old, new), state.point, moved)
        mu = jnp.where(centred & ~last, _SHRINK * state.mu, state.mu)
        return _State(point, mu, state.steps + 1, centred & last)

    ended = jax.lax.while_loop(lambda s: ~s.done & (s.steps < _MOST_STEPS), follow, first)
    x = ended.point.x
    return Minimum(x, problem.value(x), ended.point.u - barriers * ended.mu, ended.done)


def _slacks(problem: Minimax, point: _Point) -> tuple[Float[Array, " _"], ...]:
    """What has to stay positive, barrier by barrier."""
    size, p = problem.size(point.x), point.s + problem.tolerated
    return (
        p - size,
        p + size,
        point.s,
        point.u - problem.weights @ point.s,
        point.x - problem.lower,
        problem.upper - point.x,
    )


def _merit(problem: Minimax, point: _Point, mu: Float[Array, ""]) -> Float[Array, ""]:
    barrier = point.u / mu
    for slack in _slacks(problem, point):
        inside = jnp.all(slack > 0)
        barrier -= jnp.sum(jnp.log(jnp.where(slack > 0, slack, 1.0)))
        barrier = jnp.where(inside, barrier, jnp.inf)
    return barrier


def _searched(
    problem: Minimax, point: _Point, step: _Point, mu: Float[Array, ""]
) -> tuple[_Point, Bool[Array, ""]]:
    """The best of some step sizes, and whether it is better than none."""
    sizes = 0.5 ** jnp.arange(_STEP_SIZES, dtype=mu.dtype)

    def at(size: Float[Array, ""]) -> _Point:
        return jax.tree.map(lambda here, along: here + size * along, point, step)

    merits = jax.vmap(lambda size: _merit(problem, at(size), mu))(sizes)
    best = jnp.argmin(merits)
    return at(sizes[best]), merits[best] < _merit(problem, point, mu)


def _newton_step(
    problem: Minimax, point: _Point, mu: Float[Array, ""]
) -> tuple[_Point, Float[Array, ""]]:
    """Newton's step on the merit and its decrement; the slacks s are eliminated first."""
    W, J = problem.weights, problem.slope
    x, s, u = point
    size, p = problem.size(x), s + problem.tolerated
    q = 1 / ((p - size) * (p + size))
    r = 1 / (u - W @ s)
    below, above = 1 / (x - problem.lower), 1 / (problem.upper - x)
    # How the squared moduli move, by half.
    M = jnp.sum((problem.offset + J @ x)[:, :, None] * J, axis=0)
    gradient_x = 2 * q @ M - below + above
    gradient_s = -2 * p * q - 1 / s + r @ W
    gradient_u = 1 / mu - jnp.sum(r)
    H_xx = (
        2 * jnp.einsum("ckn,k,ckm->nm", J, q, J)
        + 4 * M.T @ (jnp.square(q)[:, None] * M)
        + jnp.diag(jnp.square(below) + jnp.square(above))
    )
    H_sx = -4 * (p * jnp.square(q))[:, None] * M
    H_su = -(W.T @ jnp.square(r))
    diagonal = -2 * q + 4 * jnp.square(p * q) + 1 / jnp.square(s)

    def solved_s(right: Float[Array, "points columns"]) -> Float[Array, "points columns"]:
        """(diag + Wᵀ diag(r²) W)⁻¹ of some columns, by Woodbury's identity."""
        scaled = right / diagonal[:, None]
        core = jnp.diag(1 / jnp.square(r)) + W @ (W.T / diagonal[:, None])
        return scaled - (W.T @ jnp.linalg.solve(core, W @ scaled)) / diagonal[:, None]

    coupling = jnp.concatenate([H_sx, H_su[:, None]], axis=1)
    eliminated = solved_s(jnp.concatenate([coupling, gradient_s[:, None]], axis=1))
    inverse, moved = eliminated[:, :-1], eliminated[:, -1]
    n = x.size
    H = jnp.zeros((n + 1, n + 1), x.dtype).at[:n, :n].set(H_xx)
    H = H.at[n, n].set(jnp.sum(jnp.square(r))) - coupling.T @ inverse
    gradient = jnp.append(gradient_x, gradient_u) - coupling.T @ moved
    along = _conserving(H, gradient, jnp.append(problem.balance, 0.0))
    along_s = -moved - inverse @ along
    decrement = -(gradient_x @ along[:n] + gradient_s @ along_s + gradient_u * along[n])
    return _Point(along[:n], along_s, along[n]), decrement


def _conserving(
    H: Float[Array, "n n"], gradient: Float[Array, " n"], balance: Float[Array, " n"]
) -> Float[Array, " n"]:
    """The step -H⁻¹ gradient under balance · step = 0, rows scaled to one size."""
    scale = 1 / jnp.sqrt(jnp.diagonal(H))
    nothing = jnp.all(balance == 0)
    border = jnp.append(balance * scale, jnp.where(nothing, 1.0, 0.0))
    system = jnp.zeros((H.shape[0] + 1,) * 2, H.dtype)
    system = system.at[:-1, :-1].set(jnp.outer(scale, scale) * H)
    system = system.at[-1, :].set(border).at[:, -1].set(border)
    right = jnp.append(-scale * gradient, 0.0)
    return scale * jnp.linalg.solve(system, right)[:-1]
