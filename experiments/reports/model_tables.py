"""Models compared, what was measured otherwise, and what the logs can tell, as tables."""

import math
from collections.abc import Sequence

from experiments.page.number_text import plain, readable_unit, rounded
from experiments.page.table import Table, table_of
from experiments.reports.calibration.heat_tables import quantity_symbols
from identification.checks.posterior import Posterior
from identification.checks.profile import Profile
from identification.fit.unknowns.measured import MeasuredFit
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
    best = estimate.models[estimate.choice]
    rows = [
        {
            "model": _label(model) + (" ← chosen" if model is best else ""),
            "left [times the noise]": plain(math.sqrt(model.misfit), 4),
            "AIC": f"{model.aic - best.aic:+.0f}",
            "BIC": f"{model.bic - best.bic:+.0f}",
        }
        for model in estimate.models
    ]
    if estimate.models[0].held_out is not None:
        for row, model in zip(rows, estimate.models, strict=True):
            row["held-out path, rms [mm]"] = plain(1e3 * model.path_error, 3)
    return (table_of("Models compared (AIC and BIC over the chosen one's)", rows),)


def _label(model: Model) -> str:
    return "the usual model" if not model.added else f"and {model.added[-1]}"


def measured_tables(fits: Sequence[MeasuredFit]) -> tuple[Table, ...]:
    """What was measured otherwise, beside the fit.

    Args:
        fits: The numbers.

    Returns:
        One table, or none where nothing was.
    """
    rows = (
        {
            "what": fit.measured.name.replace("_", " "),
            "at": fit.measured.setting or "",
            "measured": rounded(float(fit.measured.value), float(fit.measured.sigma)),
            "± σ": rounded(float(fit.measured.sigma), float(fit.measured.sigma)),
            "fitted": rounded(fit.value, float(fit.measured.sigma)),
            "unit": "" if fit.measured.unit == "1" else readable_unit(fit.measured.unit),
            "apart [σ]": plain(fit.deviation, 2),
        }
        for fit in fits
    )
    title = "Measured otherwise, and what the fit makes of it"
    return (table_of(title, rows),) if fits else ()


def moved_table(identifiable: Identifiability) -> Table:
    """Which quantity moves which sensor in which run.

    Args:
        identifiable: What the logs can tell.

    Returns:
        By how many standard deviations of the noise 1 % of each quantity moves them.
    """
    names = quantity_symbols(identifiable.names)
    rows = tuple(
        (run, sensor, *map(_standard_deviations, moved.tolist()))
        for run, groups in zip(identifiable.runs, identifiable.moved, strict=True)
        for sensor, moved in zip(SENSORS, groups, strict=True)
        if moved.any()
    )
    return Table(
        "What 1 % of each quantity moves, in standard deviations of the noise, all samples "
        "of a run together",
        ("run", "sensor", *names),
        rows,
    )


def _standard_deviations(moved: float) -> str:
    """What is below a hundredth of the noise can't be seen, however far below."""
    return "< 0.01" if 0 < moved < 0.01 else plain(moved, 2)


def profile_table(profiles: Sequence[Profile]) -> Table:
    """How the misfit rises along each quantity.

    Args:
        profiles: The profiles.

    Returns:
        A row for each quantity: where the misfit passes the threshold on both sides.
    """
    rows = tuple(
        (
            profile.name,
            profile.setting or "",
            profile.label,
            *("none" if math.isinf(end) else plain(end, 6) for end in profile.ends),
        )
        for profile in profiles
    )
    return Table("Profile likelihood", ("quantity", "setting", "is", "from", "to"), rows)


def posterior_table(posterior: Posterior) -> Table:
    """What the logs leave possible, by sampling.

    Args:
        posterior: The draws.

    Returns:
        A row for each quantity: its mean, spread and interval, and how far the chains agree.
    """
    rows = (
        {
            "quantity": name,
            "setting": setting or "",
            "mean": rounded(mean, spread),
            "± σ": rounded(spread, spread),
            "95 % from": rounded(low, spread),
            "to": rounded(high, spread),
            "r-hat": f"{r_hat:.3f}",
            "draws": f"{effective:.0f}",
        }
        for (name, setting), mean, spread, (low, high), r_hat, effective in zip(
            posterior.names,
            posterior.mean.tolist(),
            posterior.sigma.tolist(),
            posterior.interval().tolist(),
            posterior.r_hat.tolist(),
            posterior.effective.tolist(),
            strict=True,
        )
    )
    return table_of("Posterior (draws: how many independent ones)", rows)
