"""Relations between commands, encoders and what is known of the drives.

Each limit is what good campaigns reach, of the model's rig and of elastic ones, with a
margin of about two; `docs` has the table.
"""

import math
from collections.abc import Iterator

import numpy as np

from identification.campaign.notes.drive import BEYOND
from identification.doctor.case import Case
from identification.doctor.relations.relation import Relation, off
from identification.doctor.relations.responses import (
    Inertia,
    Response,
    drive_inertia,
    responses,
)

GAIN = 1.9
"""Factor that a gain may be off: J is 0.77 to 1.41 of the nameplate's on good rigs."""

DECAY = 3.0
"""Factor that a decay may be off."""

UNEXPLAINED = 0.72
"""Share of the acceleration that may be left: elastic cables leave 0.5 of "sum"."""

LAWLESS = 0.3
"""Share of the acceleration along y from which it isn't the command's: good rigs leave 0.01."""

PERIODS = (2e-5, 0.1)
"""Sample periods of a drive [s] that there are."""


def drive_relations(case: Case) -> Iterator[Relation]:
    """What commands and encoders say of each other, and of the rig.

    Args:
        case: The campaign.

    Yields:
        The relations that these runs have, the cheap ones first.
    """
    yield _limit(case)
    yield _period(case)
    found = responses(case)
    # Nothing gives way where the drives turn against each other. What isn't explained there
    # isn't the drives' law, and a gain of it is none.
    lawful = "difference" not in found or found["difference"].unexplained < LAWLESS
    for mode, response in found.items():
        for relation in _response(mode, response):
            if lawful or not relation.name.startswith("gain."):
                yield relation
    inertia = drive_inertia(case, found)
    if inertia is not None:
        yield _volts(inertia)


def _limit(case: Case) -> Relation:
    largest = max(float(np.max(np.abs(record.voltage))) for record in case.records)
    limit = case.rig.voltage_limit
    return Relation(
        name="limit",
        excess=largest / (BEYOND * limit),
        what=f"the largest command is {largest:.4g} V, the limit {limit:.4g} V",
        figures={"largest_V": largest, "limit_V": limit},
    )


def _period(case: Case) -> Relation:
    period = float(np.median([record.period for record in case.records]))
    return Relation(
        name="period.drive",
        excess=max(period / PERIODS[1], PERIODS[0] / period),
        what=f"the drive's sample period is {period:.4g} s",
        figures={"period_s": period},
    )


def _response(mode: str, response: Response) -> list[Relation]:
    ratio = response.gain / response.nominal_gain
    relations = [
        Relation(
            name=f"gain.{mode}",
            excess=off(ratio, GAIN),
            what=f"acceleration over command, {_spoken(mode)}: {response.gain:.4g} rad/s²/V, "
            f"{ratio:.3g} of what the rig should have",
            figures={"gain": response.gain, "nominal": response.nominal_gain},
        ),
        Relation(
            name=f"unexplained.{mode}",
            excess=response.unexplained / UNEXPLAINED,
            what=f"{response.unexplained:.0%} of the acceleration doesn't follow the command, "
            f"{_spoken(mode)}",
            figures={"share": response.unexplained},
        ),
    ]
    if mode.startswith("bare") and min(response.gain, response.decay) > 0:
        ratio = response.decay / response.nominal_decay
        relations.append(
            Relation(
                name=f"decay.{mode}",
                excess=off(ratio, DECAY),
                what=f"decay of the speed, {_spoken(mode)}: {response.decay:.4g} 1/s, "
                f"{ratio:.3g} of what the rig should have",
                figures={"decay": response.decay, "nominal": response.nominal_decay},
            )
        )
    return relations


def _spoken(mode: str) -> str:
    return {"sum": "both drives forwards", "difference": "drives against each other"}.get(
        mode, mode.replace("bare", "bare drive")
    )


def _volts(inertia: Inertia) -> Relation:
    allowed = math.exp(inertia.error)
    return Relation(
        name="volts",
        excess=off(inertia.ratio, allowed),
        what=f"torque for a volt is {inertia.ratio:.3g} of what the rig should have, within a "
        f"factor of {allowed:.3g}",
        figures={
            "ratio": inertia.ratio,
            "factor": allowed,
            "drive_inertia": inertia.value,
        },
    )
