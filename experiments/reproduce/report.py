"""The report of a reproduction: one HTML file, and its claims as a table."""

import collections
import csv
import io
import pathlib
from collections.abc import Callable, Sequence
from typing import NamedTuple

from experiments.number_text import readable_unit, short
from experiments.page import Pictures, page, versions
from experiments.reproduce.claim import Claim, Verdict
from experiments.reproduce.claims import of_section
from experiments.reproduce.content import Content, Section
from scdpr_jax.files import write_whole


class Judged(NamedTuple):
    """A claim with what was computed for it."""

    claim: Claim
    """The claim."""
    ours: float
    """What this software makes of it [in the claim's unit]."""

    @property
    def stands(self) -> bool:
        """Whether the number bears the verdict out."""
        return self.claim.stands(self.ours)

    @property
    def number(self) -> str:
        """The number as it is printed."""
        return short(self.ours, 4)

    @property
    def unit(self) -> str:
        """The unit as it is printed."""
        return "" if self.claim.unit == "1" else readable_unit(self.claim.unit)


class Reproduced(NamedTuple):
    """A section, computed and drawn."""

    section: Section
    """The section."""
    content: Content
    """What it says and shows."""
    judged: tuple[Judged, ...]
    """Its claims."""


def reproduce(
    sections: Sequence[Section], progress: Callable[[str, float], None]
) -> tuple[Reproduced, ...]:
    """Compute and draw sections.

    Args:
        sections: The sections.
        progress: Told what is being done and which share of it is done.

    Returns:
        Everything for the report.
    """
    picture, total, done, found = Pictures(), sum(s.seconds for s in sections), 0.0, []
    for section in sections:
        progress(section.name, done / total)
        content = section.build(picture)
        judged = tuple(Judged(claim, claim.compute()) for claim in of_section(section.name))
        found.append(Reproduced(section, content, judged))
        done += section.seconds
    return tuple(found)


def counts(found: Sequence[Reproduced]) -> dict[Verdict, int]:
    """How many claims have each verdict.

    Args:
        found: What was reproduced.

    Returns:
        Number of claims by verdict, every verdict among them.
    """
    each = collections.Counter(one.claim.verdict for part in found for one in part.judged)
    return {verdict: each[verdict] for verdict in Verdict}


def write(found: Sequence[Reproduced], out: pathlib.Path) -> tuple[pathlib.Path, ...]:
    """Write report.html and claims.csv, each whole or not at all.

    Args:
        found: What was reproduced.
        out: The folder.

    Returns:
        The files.

    Raises:
        OSError: If the place can't be written to.
    """
    report, table = out / "report.html", out / "claims.csv"
    text = page(
        "reproduce.html.j2",
        title="The paper, figure by figure, and judged",
        found=found,
        counts=[(verdict.value, count) for verdict, count in counts(found).items()],
        fallen=[one for part in found for one in part.judged if not one.stands],
        provenance=versions(),
    )
    write_whole(report, text)
    write_whole(table, claims_table(found))
    return report, table


def claims_table(found: Sequence[Reproduced]) -> str:
    """The claims as CSV.

    Args:
        found: What was reproduced.

    Returns:
        The table, its header first.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    writer.writerows(_cells(one) for part in found for one in part.judged)
    return text.getvalue()


_COLUMNS = (
    "section",
    "where",
    "what",
    "printed",
    "computed",
    "unit",
    "lowest accepted",
    "highest accepted",
    "tolerance because",
    "verdict",
    "verdict because",
)


def _cells(one: Judged) -> tuple[str, ...]:
    claim = one.claim
    low, high = (f"{bound:.6g}" for bound in claim.accepted)
    told = (claim.section, claim.where, claim.what, claim.printed, f"{one.ours:.6g}")
    return (*told, claim.unit, low, high, claim.reason, claim.verdict.value, claim.because)
