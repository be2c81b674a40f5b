"""Whether a calibration can be trusted, in a colour, a word and a reason."""

import dataclasses
from collections.abc import Iterator

from experiments.page.coordinates import COORDINATES
from experiments.page.number_text import capitalised, percent, plain
from experiments.studies.findings.findings import Findings
from experiments.studies.findings.parameters import estimated
from experiments.studies.findings.plausibility import (
    contradiction_sentence,
    implausible,
    ringing_doubts,
    settings_alike,
)
from experiments.studies.findings.residuals import fitted_runs
from experiments.studies.findings.verdict import doubts

POORLY = 0.02
"""Error of a held-out run over its motion from which it is predicted poorly [1]: on a rig that
the model explains it is a tenth of this at most."""


@dataclasses.dataclass(frozen=True)
class Trust:
    """How far a calibration can be trusted."""

    level: str
    """`good`, `care` or `bad`."""
    word: str
    """The same in a word."""
    reason: str
    """Why, in a sentence or two."""
    others: tuple[str, ...] = ()
    """Further reasons, a sentence each."""


def trust(findings: Findings) -> Trust:
    """How far a calibration can be trusted.

    Args:
        findings: What it comes to.

    Returns:
        The verdict; its reason is the weightiest one.
    """
    if findings.verdict:
        return Trust("bad", "No", findings.verdict[0], findings.verdict[1:])
    unstable = _unstable(findings)
    if unstable:
        return Trust("bad", "No", unstable)
    reasons = tuple(_reasons(findings))
    if reasons:
        return Trust("care", "With care", reasons[0], reasons[1:])
    return Trust("good", "Yes", _explained(findings))


def _unstable(findings: Findings) -> str:
    """That the gains aren't stable on the flexible robot; empty if they are."""
    margins = () if findings.tuning is None else findings.tuning.tuning.worst_margins
    if any(margin.measure == "spectral_radius" for margin in margins):
        return "With these gains the flexible robot is unstable: don't run them."
    return ""


def _reasons(findings: Findings) -> Iterator[str]:
    """What speaks against a calibration, the weightiest first."""
    estimate, frequencies = findings.estimate, findings.frequencies
    if findings.excesses:
        yield _excess(findings)
    badly: dict[str, list[str]] = {}
    for p in estimated(estimate):
        if p.status != "identified":
            badly.setdefault(p.status, []).append(_name(p.name, p.setting))
    said = {
        "weak": "only weakly identified",
        "unidentifiable": "not told by these runs",
        "at_bound": "at the bound of what is allowed",
    }
    for status, names in badly.items():
        yield f"{capitalised(_listed(names))}: {said.get(status, status.replace('_', ' '))}."
    yield from doubts(estimate)
    yield from (contradiction_sentence(fit) for fit in findings.measured if fit.is_contradicted)
    for held_out in findings.predictions:
        if held_out.share > POORLY:
            yield (
                f"{held_out.run}, which was not fitted, is predicted to "
                f"{plain(1e3 * held_out.error)} mm rms, {percent(held_out.share)} of its "
                "motion."
            )
    if estimate.fit.ended != "converged":
        yield "The fit didn't meet its stopping rule: the intervals may be too narrow."
    if findings.campaign is not None:
        yield from implausible(estimate, findings.campaign)
    yield from settings_alike(estimate)
    if frequencies is not None:
        yield from ringing_doubts(frequencies, estimate.robot)


def _excess(findings: Findings) -> str:
    worst = findings.excesses[0]
    total = sum(len(run.channels) for run in fitted_runs(findings.estimate))
    return (
        f"{len(findings.excesses)} of {total} channels leave more than noise, most of all "
        f"{COORDINATES[worst.channel.name].symbol} of {worst.run}: {worst.size_text} rms, "
        f"{plain(worst.channel.chi_square**0.5)} times the noise."
    )


def _explained(findings: Findings) -> str:
    fitted = len(fitted_runs(findings.estimate))
    runs = "The run is" if fitted == 1 else f"All {fitted} fitted runs are"
    reason = f"{runs} explained down to the sensors' noise"
    if not findings.predictions:
        return f"{reason}. No run was held out to put the model to the test."
    worst = max(findings.predictions, key=lambda one: one.error)
    share = f", {percent(worst.share)} of its motion" if worst.motion > 0 else ""
    return (
        f"{reason}, and {worst.run}, which was not fitted, is predicted to "
        f"{plain(1e3 * worst.error)} mm rms{share}."
    )


def _name(name: str, setting: str | None) -> str:
    words = name.replace("_", " ")
    return f"{words} at {setting}" if setting else words


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
