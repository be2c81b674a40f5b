"""What the logs can tell of which quantity, and which model explains them, as tables."""

import math
from collections.abc import Sequence

from experiments.page.number_text import plain, rounded
from experiments.page.table import Table
from identification.checks.posterior import Posterior
from identification.checks.profile import Profile
from identification.fit.unknowns.models import Model
from identification.judge.identifiability import SENSORS, Identifiability
from identification.result.estimate import Estimate


def model_tables(estimate: Estimate) -> tuple[Table, ...]:
    """The models that were compared.

    Args:
        estimate: The estimate.

    Returns:
        One table, or none where the usual model is enough.
    """
    if not estimate.models:
        return ()
    held_out = estimate.models[0].held_out is not None
    header = (
        "model",
        "misfit",
        "AIC",
        "BIC",
        *(("held-out path, rms [mm]",) if held_out else ()),
    )
    best = estimate.models[estimate.choice]
    rows = tuple(
        (
            _label(model) + (" ← chosen" if model is best else ""),
            plain(model.misfit, 4),
            f"{model.aic - best.aic:+.0f}",
            f"{model.bic - best.bic:+.0f}",
            *((plain(1e3 * model.path_error, 3),) if held_out else ()),
        )
        for model in estimate.models
    )
    title = "Models compared (AIC and BIC over the chosen one's)"
    return (Table(title, header, rows),)


def _label(model: Model) -> str:
    return "the usual model" if not model.added else f"and {model.added[-1]}"


def verdict_on_models(estimate: Estimate) -> tuple[str, ...]:
    """What the usual model lacks, in words.

    Args:
        estimate: The estimate.

    Returns:
        A sentence, or none where the usual model is enough.
    """
    if not estimate.models:
        return ()
    usual, best = estimate.models[0], estimate.models[estimate.choice]
    by = (
        ""
        if best.path_error is None
        else (
            f" It predicts the end-effector's path in the held-out runs to "
            f"{plain(1e3 * best.path_error, 3)} mm rms, the usual one to "
            f"{plain(1e3 * usual.path_error, 3)} mm."
        )
    )
    if not best.added:
        return (
            f"Of {len(estimate.models)} models none is better than the usual one, though it "
            f"leaves more than noise: what it lacks isn't among what was tried.{by}",
        )
    return (f"The usual model lacks {'; '.join(best.added)}.{by}",)


def moved_table(found: Identifiability) -> Table:
    """Which quantity moves which sensor in which run.

    Args:
        found: What the logs can tell.

    Returns:
        By how many standard deviations of the noise 1 % of each quantity moves them.
    """
    header = (
        "run",
        "sensor",
        *(name.replace("_", " ") + (f" {s}" if s else "") for name, s in found.names),
    )
    rows = []
    for run, groups in zip(found.runs, found.moved, strict=True):
        for sensor, moved in zip(SENSORS, groups, strict=True):
            if moved.any():
                rows.append((run, sensor, *map(_standard_deviations, moved.tolist())))
    return Table(
        "What 1 % of each quantity moves, in standard deviations of the noise, all samples "
        "of a run together",
        header,
        tuple(rows),
    )


def _standard_deviations(moved: float) -> str:
    """What is below a hundredth of the noise can't be seen, however far below."""
    return "< 0.01" if 0 < moved < 0.01 else plain(moved, 2)


def told_combinations(found: Identifiability) -> tuple[str, ...]:
    """What these logs tell, and what they can't, in words.

    Args:
        found: What the logs can tell.

    Returns:
        A sentence on each combination that they don't tell; on the worst one otherwise.
    """
    untold = found.untold()
    if not untold:
        worst = found.combinations[-1]
        return (
            f"These logs tell all {len(found.names)} quantities apart; the least sharp is "
            f"{worst.text()}, {plain(1e2 * worst.sigma, 2)} % by the noise alone.",
        )
    return tuple(
        f"These logs can't tell {one.text()}: "
        + (
            "nothing that was measured changes with it."
            if one.sigma == float("inf")
            else f"its standard error is {plain(1e2 * one.sigma, 2)} % by the noise alone."
        )
        for one in untold
    )


def profile_table(profiles: Sequence[Profile]) -> Table:
    """How the misfit rises along each quantity.

    Args:
        profiles: The profiles.

    Returns:
        A row for each quantity: where the misfit passes the threshold on both sides.
    """
    rows = tuple(
        (
            one.name,
            one.setting or "",
            one.label,
            *("none" if math.isinf(end) else plain(end, 6) for end in one.ends),
        )
        for one in profiles
    )
    return Table("Profile likelihood", ("quantity", "setting", "is", "from", "to"), rows)


def posterior_table(posterior: Posterior) -> Table:
    """What the logs leave possible, by sampling.

    Args:
        posterior: The draws.

    Returns:
        A row for each quantity: its mean, spread and interval, and how far the chains agree.
    """
    rows = tuple(
        (
            name,
            setting or "",
            rounded(mean, spread),
            rounded(spread, spread),
            *(rounded(end, spread) for end in ends),
            f"{r_hat:.3f}",
            f"{effective:.0f}",
        )
        for (name, setting), mean, spread, ends, r_hat, effective in zip(
            posterior.names,
            posterior.mean.tolist(),
            posterior.sigma.tolist(),
            posterior.interval().tolist(),
            posterior.r_hat.tolist(),
            posterior.effective.tolist(),
            strict=True,
        )
    )
    header = ("quantity", "setting", "mean", "± σ", "95 % from", "to", "r-hat", "draws")
    return Table("Posterior (draws: how many independent ones)", header, rows)
