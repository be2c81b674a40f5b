r"""What the logs leave possible, by sampling: beyond an interval from a parabola.

The posterior of a fit's unknowns $x$ with a flat prior in what the fit holds (logarithms of
what must be positive) is

$$ p(x) \propto e^{-\text{misfit}(x)/2} , $$

with the misfit of the fit, so with what was measured otherwise. Hamiltonian Monte Carlo
without U-turns walks it from the fit on. With $x = \hat x + A z$ and $A A^T$ the inverse of
the Gauss-Newton matrix, $z$ is nearly standard normal, so that no mass matrix needs to be
learnt. A quantity that may be zero is reflected there: the walk is on $|x|$.

Reference: M. D. Hoffman, A. Gelman, "The No-U-Turn Sampler", J. Machine Learning Research 15,
2014; A. Vehtari et al., "Rank-normalization, folding, and localization: an improved R-hat",
Bayesian Analysis 16(2), 2021, doi:10.1214/20-BA1221.
"""

import importlib.util

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.campaign.types import Campaign
from identification.fit.lanes import over_lanes
from identification.fit.problem import Problem
from identification.fit.run_sums import motor_sums, run_sums
from identification.fit.unknowns.measured import pulls
from identification.judge.influence import decoded
from identification.judge.likelihood import Posterior
from identification.result.estimate import Estimate
from identification.result.estimation import solved
from scdpr_jax.numerics.merit import Normal
from scdpr_jax.numerics.progress import SILENT, Progress, listening

APART = 1.01
"""Largest potential scale reduction that is taken for convergence [1]."""

ENOUGH = 400.0
"""Least independent draws of each quantity, for steady ends of an interval [1]."""

ROUNDS = 24
"""Rounds of draws before a posterior that hasn't converged is refused."""


class _Sampled:
    """A posterior as a function of standardised unknowns."""

    def __init__(self, problem: Problem, point: Float[np.ndarray, " n"]) -> None:
        (normal,) = problem.evaluate([point])
        self.problem, self.point = problem, point
        self.at, self.scale = _standardised(problem, normal)
        bounded = np.isfinite(problem.unknowns.lower()[self.at])
        self.folds = jnp.asarray(bounded)

    def values(self, z: Float[Array, " active"]) -> Float[Array, " n"]:
        """The fit's vector that standardised unknowns stand for."""
        moved = self.point[self.at] + self.scale @ z
        folded = jnp.where(self.folds, jnp.abs(moved), moved)
        return jnp.asarray(self.point).at[self.at].set(folded)

    def potential(self, z: Float[Array, " active"]) -> Float[Array, ""]:
        """Half of the misfit, whose derivative is that of the fit's normal equations."""
        return _half_misfit(self.problem, self.values(z))


def _standardised(
    problem: Problem, normal: Normal
) -> tuple[np.ndarray, Float[np.ndarray, "active active"]]:
    """Unknowns that the logs tell, and a root of their covariance."""
    is_open = problem.unknowns.open_to(problem.fitted())
    at = np.flatnonzero(is_open & (np.diag(normal.matrix) > 0))
    size = 1 / np.sqrt(np.diag(normal.matrix)[at])
    values, vectors = np.linalg.eigh(normal.matrix[np.ix_(at, at)] * np.outer(size, size))
    # A combination that the logs don't tell would be walked forever.
    values = np.maximum(values, 1e-8 * values[-1])
    return at, size[:, None] * vectors / np.sqrt(values)


def _half_misfit(problem: Problem, vector: Float[Array, " n"]) -> Float[Array, ""]:
    @jax.custom_vjp
    def half(x: Float[Array, " n"]) -> Float[Array, ""]:
        return both(x)[0]

    def both(x: Float[Array, " n"]) -> tuple[Float[Array, ""], Float[Array, " n"]]:
        logs, unknowns, free = problem.logs, problem.unknowns, problem.unknowns.free
        cost, slope = jnp.zeros(()), jnp.zeros_like(x)
        rows = [k for k, i in enumerate(logs.cabled) if i not in problem.held_out]
        parts = []
        if rows:
            at = np.stack([unknowns.of_run(logs.cabled[k]) for k in rows])
            records = jax.tree.map(lambda leaf: leaf[np.array(rows)], logs.rough)
            sums = over_lanes(run_sums, problem.prior, free, x[at], records)
            parts.append((at, sums.gradient, jnp.sum(sums.cost) + jnp.sum(sums.prior_cost)))
        bare = [k for k, i in enumerate(logs.motors) if i not in problem.held_out]
        if bare:
            at = np.stack([unknowns.of_bare(logs.motors[k]) for k in bare])
            records = jax.tree.map(lambda leaf: leaf[np.array(bare)], logs.motor_records)
            sums = over_lanes(motor_sums, problem.prior, free, x[at], records)
            parts.append((at, sums.gradient, jnp.sum(sums.cost)))
        if problem.options.measured:
            at = problem.measured_places()
            pull, slopes = pulls(problem.options.measured, problem.prior, free, x[at])
            parts.append((at, pull[:, None] * slopes, jnp.sum(jnp.square(pull))))
        for at, gradient, misfit in parts:
            cost, slope = cost + misfit, slope.at[at].add(gradient)
        return cost / 2, slope

    half.defvjp(both, lambda slope, outer: (outer * slope,))
    return half(vector)


def posterior(
    campaign: Campaign,
    estimate: Estimate,
    *,
    chains: int = 4,
    warm_up: int = 100,
    draws: int = 50,
    seed: int = 0,
    progress: Progress | bool = SILENT,
) -> Posterior:
    """Draws from what the logs leave possible, beginning at the fit.

    It takes the residuals for the sensors' noise where they are no larger, and an error of
    the model as the misfit does; it knows nothing of residuals that hang together in time.

    Args:
        campaign: The campaign that the estimate is of.
        estimate: The estimate.
        chains: Walks, side by side.
        warm_up: Steps in which the step's length is learnt.
        draws: Draws of every chain in a round; rounds are added until the chains agree and
            are worth `ENOUGH` independent draws.
        seed: Of the random numbers.
        progress: Told what is being done and which share of it is done;
            True shows it in a notebook.

    Returns:
        The draws.

    Raises:
        ValueError: If numpyro isn't installed.
        FloatingPointError: If the chains don't agree in the end.
    """
    progress = listening(progress)
    require_numpyro()
    from numpyro.diagnostics import effective_sample_size, split_gelman_rubin
    from numpyro.infer import MCMC, NUTS

    problem, point = solved(campaign, estimate)
    sampled = _Sampled(problem, point)
    kernel = NUTS(
        potential_fn=sampled.potential,
        adapt_mass_matrix=False,
        step_size=0.5,
        max_tree_depth=5,
    )
    walk = MCMC(
        kernel,
        num_warmup=warm_up,
        num_samples=draws,
        num_chains=chains,
        chain_method="vectorized",
        progress_bar=False,
    )
    keys = jax.random.split(jax.random.key(seed), 2)
    begun = jax.random.normal(keys[0], (chains, sampled.at.size))
    opened = np.flatnonzero(problem.unknowns.opened)
    names = problem.unknowns.opened_names
    taken = []
    for number in range(ROUNDS):
        progress("draws from the posterior", number / ROUNDS)
        # The sampler mixes integers with floats, which a strict caller forbids.
        with jax.numpy_dtype_promotion("standard"):
            if number:
                walk.post_warmup_state = walk.last_state
                walk.run(walk.last_state.rng_key)
            else:
                walk.run(keys[1], init_params=begun)
        z = walk.get_samples(group_by_chain=True)
        encoded = np.asarray(jax.vmap(jax.vmap(sampled.values))(z))[:, :, opened]
        taken.append(decoded([n for n, _ in names], encoded.reshape(-1, len(names))))
        whole = np.concatenate([part.reshape(chains, -1, len(names)) for part in taken], axis=1)
        r_hat = np.asarray(split_gelman_rubin(whole))
        effective = np.asarray(effective_sample_size(whole))
        if np.all(r_hat <= APART) and np.all(effective >= ENOUGH):
            return Posterior(names, whole, r_hat, effective)
    worst = int(np.argmax(r_hat))
    raise FloatingPointError(
        f"the posterior's chains don't agree after {whole.shape[1]} draws each: r-hat of "
        f"{names[worst][0]} is {r_hat[worst]:.3f}, expected {APART} or less, and at worst "
        f"{effective.min():.0f} independent draws, expected {ENOUGH:.0f}. The logs may leave a "
        "combination open: look at the profiles."
    )


def require_numpyro() -> None:
    """Refuse without the sampler's library.

    Raises:
        ValueError: If numpyro isn't installed.
    """
    if importlib.util.find_spec("numpyro") is None:
        raise ValueError(
            "a posterior needs numpyro, which isn't installed. Install it with "
            '`pip install "scdpr-jax[bayes]"`.'
        )
