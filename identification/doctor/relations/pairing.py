"""A run's camera beside its encoders, frame by frame."""

import dataclasses

import numpy as np
from jaxtyping import Float64

from identification.doctor.case import FEWEST_FRAMES, Q3, Case, Record, Y
from identification.doctor.statistics import travel

MOVES = 0.03
"""Travel [m] from which on a run's motion is more than its elasticity."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Pairing:
    """The frames of a run at which there are encoders, too."""

    record: Record
    """The run."""
    time: Float64[np.ndarray, " frames"]
    """Time of the frames on the drive's clock [s]."""
    position: Float64[np.ndarray, "frames 5"]
    """The camera's positions [m, rad]."""
    along: Float64[np.ndarray, " frames"]
    r"""Travel of the lower carriage by the encoders, $r (\\alpha_1 + \\alpha_2) / 2$ [m]."""
    up: Float64[np.ndarray, " frames"]
    r"""Rise of the end-effector by the encoders, $r (\\alpha_1 - \\alpha_2) / 2$ [m]."""

    @property
    def moves(self) -> bool:
        """Whether anything travels more than the cable's elasticity."""
        signals = (self.position[:, Q3], self.position[:, Y], self.along, self.up)
        return max(map(travel, signals)) > MOVES


def pairing(record: Record, radius: float) -> Pairing | None:
    """The frames of a run with the encoders' angles between its samples.

    Args:
        record: The run.
        radius: Radius of the driver pulleys [m].

    Returns:
        The pairing without frames in gaps of the drive or outside its log; None if too few
        are left.
    """
    if not record.filmed:
        return None
    time = record.frame_time - record.offset
    inside = (time >= record.time[0] - 1e-9) & (time <= record.time[-1] + 1e-9)
    if not record.trusted.all():
        trusted = np.interp(time, record.time, record.trusted.astype(float))
        inside &= trusted > 0.99
    for begin, end in record.gaps:
        inside &= (time < begin) | (time > end)
    if inside.sum() < FEWEST_FRAMES:
        return None
    time = time[inside]
    first, second = (np.interp(time, record.time, record.angle[:, drive]) for drive in (0, 1))
    return Pairing(
        record=record,
        time=time,
        position=record.position[inside],
        along=radius * (first + second) / 2,
        up=radius * (first - second) / 2,
    )


def pairings(case: Case) -> tuple[Pairing, ...]:
    """The pairings of all runs that have one.

    Args:
        case: The campaign.

    Returns:
        The pairings.
    """
    found = (pairing(record, case.rig.radius) for record in case.filmed)
    return tuple(each for each in found if each is not None)
