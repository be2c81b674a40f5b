"""The report of a reproduction: one HTML file, and its claims as a table."""

import collections
import csv
import dataclasses
import io
import pathlib
from collections.abc import Callable, Iterator, Sequence

from matplotlib.figure import Figure

from experiments.page.number_text import readable_unit, short
from experiments.page.page import Pictures, page, versions
from experiments.paper.claim import Claim, Verdict
from experiments.paper.content import Content, Section
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.numerics.progress import Progress

_PNG_DPI = 75  # a column of the documentation, and files of some 50 kB


@dataclasses.dataclass(frozen=True)
class Judged:
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
        unit = self.claim.printed.unit
        return "" if unit == "1" else readable_unit(unit)


@dataclasses.dataclass(frozen=True)
class Reproduced:
    """A section, computed and drawn."""

    section: Section
    """The section."""
    content: Content
    """What it says and shows."""
    judged: tuple[Judged, ...]
    """Its claims."""


def reproduce(
    sections: Sequence[Section],
    progress: Progress,
    *,
    keep: Callable[[str, Figure], None] = lambda name, figure: None,
) -> tuple[Reproduced, ...]:
    """Compute and draw sections.

    Args:
        sections: The sections.
        progress: Told what is being done and which share of it is done.
        keep: Told every figure with its section's name, to keep it as a file of its own.

    Returns:
        Everything for the report.
    """
    total, done = sum(section.seconds for section in sections), 0.0
    parts: list[Reproduced] = []
    picture = Pictures(lambda figure: keep(sections[len(parts)].name, figure))
    for section in sections:
        progress(section.name, done / total)
        content = section.build(picture)
        judged = tuple(Judged(claim, claim.compute()) for claim in section.claims)
        parts.append(Reproduced(section, content, judged))
        done += section.seconds
    return tuple(parts)


def png_files(out: pathlib.Path) -> Callable[[str, Figure], None]:
    """What keeps every figure as a PNG file named by its section.

    Args:
        out: The folder, made if it is missing.

    Returns:
        What `reproduce` takes as `keep`.
    """
    drawn: collections.Counter[str] = collections.Counter()

    def keep(name: str, figure: Figure) -> None:
        drawn[name] += 1
        number = f"-{drawn[name]}" if drawn[name] > 1 else ""
        out.mkdir(parents=True, exist_ok=True)
        figure.savefig(out / f"{name}{number}.png", dpi=_PNG_DPI)

    return keep


def counts(parts: Sequence[Reproduced]) -> dict[Verdict, int]:
    """How many claims have each verdict.

    Args:
        parts: What was reproduced.

    Returns:
        Number of claims by verdict, every verdict among them.
    """
    each = collections.Counter(one.claim.verdict for part in parts for one in part.judged)
    return {verdict: each[verdict] for verdict in Verdict}


def told(parts: Sequence[Reproduced]) -> Iterator[str]:
    """What came of it, in lines.

    Args:
        parts: What was reproduced.

    Yields:
        How often each verdict was found, and what isn't borne out.
    """
    for verdict, count in counts(parts).items():
        yield f"{count:4d} {verdict.value}"
    for one in (each for part in parts for each in part.judged if not each.stands):
        yield (
            f"not borne out: {one.claim.name}: computed {one.number} {one.unit}, said to be "
            f"{one.claim.verdict.value}"
        )


def write(parts: Sequence[Reproduced], out: pathlib.Path) -> tuple[pathlib.Path, ...]:
    """Write report.html and claims.csv, each whole or not at all.

    Args:
        parts: What was reproduced.
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
        parts=parts,
        counts=[(verdict.value, count) for verdict, count in counts(parts).items()],
        fallen=[each for part in parts for each in part.judged if not each.stands],
        provenance=versions(),
    )
    write_whole(report, text)
    write_whole(table, claims_table(parts))
    return report, table


def claims_table(parts: Sequence[Reproduced]) -> str:
    """The claims as CSV.

    Args:
        parts: What was reproduced.

    Returns:
        The table, its header first.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    for part in parts:
        writer.writerows(_cells(part.section.name, one) for one in part.judged)
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


def _cells(section: str, judged: Judged) -> tuple[str, ...]:
    claim, printed = judged.claim, judged.claim.printed
    low, high = (f"{bound:.6g}" for bound in printed.accepted)
    number = (printed.text, f"{judged.ours:.6g}", printed.unit, low, high, printed.reason)
    verdict = (claim.verdict.value, claim.because)
    return (section, printed.where, claim.what, *number, *verdict)
