"""Which slip explains what doesn't hold.

Every slip is undone in memory, and all relations are examined again: the right one leaves
nothing. Severities are logarithms, so that a slip that mends a gross contradiction and leaves
a small one is worse than one that leaves none. Ties go to the order of the catalogue.

One bad run spoils what is pooled over runs, or hides in it. So where no slip in all runs
leaves nothing, or leaves runs that are odd by themselves, a slip in the odd runs alone is
tried; and where that doesn't, two slips, each of the four best ones followed by another.
"""

import math
from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

from identification.doctor.case import Case
from identification.doctor.findings import Finding
from identification.doctor.relations import Examination, examination, may_help
from identification.doctor.slips.catalogue import CATALOGUE
from identification.doctor.slips.edits import Undone
from identification.doctor.slips.slip import Slip
from identification.doctor.words import explained

SURE = 0.3
"""Severity that may be left: a relation that is just broken counts as much."""

ODD = 0.45
"""Severity of one run alone that makes it odd: it has larger errors than a campaign."""

PRICE = 1.0
"""What a second slip must mend, to be told, where it leaves something: where it leaves nothing
and the first one did, `SURE` is enough. A relation that says how much isn't explained can't be
off by more than all of it, and would never weigh as much as the price."""

BEST = 4
"""First slips that are followed by a second one."""

MARGIN = 0.5
"""Severity within which another explanation is told as an alternative."""

VANISHED = 3.0
"""What it counts against a slip that undoing it leaves a drive no motion to be judged by."""

WORTH = 0.7
"""Share of the severity that may be left at most; else nothing explains it."""


class Explanation(NamedTuple):
    """One or two slips undone."""

    left: float
    """Severity that is left, and the price of a second slip."""
    slips: tuple[Slip, ...]
    """The slips."""
    steps: tuple[Mapping[str, Any], ...]
    """How they were undone."""
    examination: Examination | None
    """What the sensors say then; None of what isn't among the four best, as each holds signals
    of its own, and fifty of them would be ten times the log."""
    also: tuple[str, ...] = ()
    """Slips that may be in the same factors, as data can't tell."""

    @property
    def rank(self) -> float:
        """What explanations are compared by: below it, differences are noise."""
        return round(self.left, 2)


def conclusion(case: Case) -> tuple[Case, tuple[Finding, ...]]:
    """What explains a case that contradicts itself.

    Args:
        case: The campaign, bad samples put right.

    Returns:
        The case with the slips undone, and a finding for each; the case as it is and none
        where everything holds.
    """
    base = examination(case)
    if base.severity == 0:
        odd = odd_runs(base.case)
        if not 0 < len(odd) < len(case.records):
            return base.case, ()
        part, findings = _concluded(examination(base.case.only(odd)))
        return base.case.updated(part.records), findings
    return _concluded(base)


def odd_runs(case: Case) -> tuple[str, ...]:
    """The runs that contradict themselves.

    Args:
        case: The campaign.

    Returns:
        Their names.
    """
    return tuple(
        record.name
        for record in case.records
        if examination(case.only((record.name,))).severity > ODD
    )


def _concluded(base: Examination) -> tuple[Case, tuple[Finding, ...]]:
    case = base.case
    names = tuple(record.name for record in case.records)
    if base.severity == 0:
        return case, ()
    options, wrong = _search(base) or [Explanation(base.severity, (), (), base)], base.severity
    if options[0].left > SURE or odd_runs(options[0].examination.case):
        some, names_of_some = _in_odd_runs(base)
        if options[0].left > SURE and not (some and some[0].left < SURE):
            options = _pairs(options)
        both = wrong + _severity_in(base, names_of_some)
        least = options[0].left + _severity_in(options[0].examination, names_of_some)
        if some and some[0].left < max(SURE, min(least, WORTH * both)):
            options, names, wrong = some, names_of_some, both
    best = options[0]
    figures = [(each.name, each.what, each.figures) for each in base.broken]
    if best.left > WORTH * wrong:
        nothing = explained(
            "unexplained", "nothing fits", {}, figures=figures, runs=names, alternatives=()
        )
        return case, (nothing,)
    findings = tuple(
        explained(
            slip.id,
            slip.what,
            step,
            figures=figures,
            runs=names,
            alternatives=_alternatives(options),
        )
        for slip, step in zip(best.slips, best.steps, strict=True)
    )
    return best.examination.case, findings


def _severity_in(whole: Examination, runs: Collection[str]) -> float:
    """Severity of some runs by themselves, none for none."""
    return examination(whole.case.only(runs)).severity if runs else 0.0


def _search(base: Examination) -> list[Explanation]:
    """Every slip undone, the best explanation first."""
    found: list[Explanation] = []
    for slip, undone in _undone(base):
        # What is worse than the four best ones by the margin of an alternative is neither
        # told nor followed by a second slip: it needn't be known how much worse.
        enough = found[BEST - 1].left + MARGIN if len(found) >= BEST else math.inf
        found.append(_explanation(base, slip, undone, enough))
        found.sort(key=lambda each: each.rank)  # stable: ties keep their order
        found[BEST:] = [each._replace(examination=None) for each in found[BEST:]]
    return found


def _undone(base: Examination, without: Collection[str] = ()) -> Iterator[tuple[Slip, Undone]]:
    """Every slip that touches what doesn't hold, undone."""
    for slip in CATALOGUE:
        undone = None if slip.id in without else slip.undo(base.case)
        if undone is not None and may_help(undone.case, base):
            yield slip, undone


def _explanation(base: Examination, slip: Slip, undone: Undone, enough: float) -> Explanation:
    """What a slip undone leaves; above what is enough it may be more than is told."""
    after = examination(undone.case, base, enough=enough)
    left = after.severity + VANISHED * _vanished(base, after, slip)
    return Explanation(left, (slip,), (undone.step,), after, undone.also)


def _vanished(base: Examination, after: Examination, slip: Slip) -> int:
    """Drives whose gain there was and is no more: a factor made their motion vanish.

    What moved forwards may well move up and down: the robot's two modes count as one.
    """
    if slip.id == "label.kind":  # it takes a run's drives out of judgement, and may
        return 0
    return len(_gained(base) - _gained(after))


def _gained(examination: Examination) -> set[str]:
    names = [each.name for each in examination.drives if each.name.startswith("gain.")]
    return {name if name.startswith("gain.bare") else "robot" for name in names}


def _pairs(first: list[Explanation]) -> list[Explanation]:
    """The best pair that begins with one of the best first slips, beside single ones."""
    best = first[0]
    for start in [each for each in first[:BEST] if not _forgets(each)]:
        best = _followed(start, best)
    return first if best is first[0] else [best, *first]


def _followed(start: Explanation, best: Explanation) -> Explanation:
    """The best of a first slip with a second one, and of what is to be beaten."""
    for slip, undone in _undone(start.examination, (start.slips[0].id,)):
        # A tie is the earlier one's: what doesn't leave less needn't be known.
        enough = max(best.left - PRICE, 0.0)
        then = _explanation(start.examination, slip, undone, enough)
        pair = Explanation(
            then.left + (PRICE if then.left > 0 else SURE),
            (*start.slips, slip),
            (*start.steps, undone.step),
            then.examination,
            (*start.also, *then.also),
        )
        if pair.rank < best.rank and not _forgets(then):
            best = pair
    return best


def _forgets(explanation: Explanation) -> bool:
    """Whether it leaves the starts out of judgement, and yet something contradicts.

    Every other slip puts a signal right. Beside one of them, this would win by what it hides.
    """
    return explanation.slips[0].id == "label.initial" and explanation.left > 0


def _in_odd_runs(base: Examination) -> tuple[list[Explanation], tuple[str, ...]]:
    """Explanations by a slip in the odd runs alone, judged by the whole campaign."""
    odd = odd_runs(base.case)
    if not 0 < len(odd) < len(base.case.records):
        return [], odd
    found = []
    for each in _search(examination(base.case.only(odd)))[:BEST]:
        whole = base.case.updated(each.examination.case.records)
        after = examination(whole)
        found.append(each._replace(left=each.left + after.severity, examination=after))
    return sorted(found, key=lambda each: each.rank), odd


def _alternatives(options: list[Explanation]) -> tuple[str, ...]:
    best = options[0]
    chosen = {slip.id for slip in best.slips}
    near = [
        each.slips[0].id
        for each in options[1:12]
        if len(each.slips) == 1 and each.left < best.left + MARGIN
    ]
    return tuple(dict.fromkeys(name for name in (*near, *best.also) if name not in chosen))
