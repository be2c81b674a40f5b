"""All relations of a case, and which of them a change leaves as they were."""

import dataclasses
import math
from collections.abc import Iterator

from identification.doctor.case import Case
from identification.doctor.relations.cameras import camera_relations
from identification.doctor.relations.clocks import settled
from identification.doctor.relations.drives import drive_relations
from identification.doctor.relations.relation import Relation, severity


@dataclasses.dataclass(frozen=True, eq=False)
class Examination:
    """A case and what its sensors say of each other."""

    case: Case
    """The case, unstated clocks estimated."""
    drives: tuple[Relation, ...]
    """Relations of commands and encoders."""
    cameras: tuple[Relation, ...]
    """Relations of the camera."""

    @property
    def relations(self) -> tuple[Relation, ...]:
        """All relations."""
        return (*self.drives, *self.cameras)

    @property
    def broken(self) -> tuple[Relation, ...]:
        """The relations that don't hold, the worst first."""
        found = [relation for relation in self.relations if relation.broken]
        return tuple(sorted(found, key=lambda relation: -relation.excess))

    @property
    def severity(self) -> float:
        """How far the case is from a good one, 0 if everything holds."""
        return severity(self.relations)


def may_help(case: Case, base: Examination) -> bool:
    """Whether anything that doesn't hold is about signals that a change has touched.

    Args:
        case: The changed case.
        base: The examination before.

    Returns:
        False if every broken relation is the same as before.
    """
    drives, cameras = _untouched(case, base)
    return (severity(base.drives) > 0 and not drives) or (
        severity(base.cameras) > 0 and not cameras
    )


def examination(
    case: Case, before: Examination | None = None, *, enough: float = math.inf
) -> Examination:
    """What the sensors of a case say of each other.

    Args:
        case: The campaign.
        before: The examination of another case, whose relations are taken over where the
            signals are the very same arrays.
        enough: Severity at which it is no use to look further.

    Returns:
        The examination; above `enough` it isn't complete.
    """
    case = settled(case)
    drives, cameras = (False, False) if before is None else _untouched(case, before)
    told = before.drives if drives else _until(drive_relations(case), enough)
    enough -= severity(told)
    return Examination(
        case, told, before.cameras if cameras else _until(camera_relations(case), enough)
    )


def _until(relations: Iterator[Relation], enough: float) -> tuple[Relation, ...]:
    """Relations one by one, until they are broken enough."""
    found: list[Relation] = []
    while enough >= 0 and (relation := next(relations, None)) is not None:
        found.append(relation)
        enough -= relation.severity
    return tuple(found)


def _untouched(case: Case, before: Examination) -> tuple[bool, bool]:
    """Whether the drives' relations, and the camera's, are those of another examination."""
    old = before.case
    if old.rig != case.rig:
        return False, False
    drives = _same(case, old, ("time", "voltage", "angle", "kind"))
    cameras = _same(case, old, ("time", "angle", "frame_time", "position", "initial"))
    offsets = [record.offset for record in case.records]
    return drives, cameras and offsets == [record.offset for record in old.records]


def _same(case: Case, other: Case, names: tuple[str, ...]) -> bool:
    return len(case.records) == len(other.records) and all(
        getattr(record, name) is getattr(twin, name)
        for record, twin in zip(case.records, other.records, strict=True)
        for name in names
    )
