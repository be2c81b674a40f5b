"""Relations between the camera, the encoders and the frame.

Each limit is what good campaigns reach, of the model's rig and of elastic ones, with a
margin of two at least; one run alone reaches more than a campaign.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float64

from identification.doctor.case import Q3, Q4, Case, D, Record, X, Y
from identification.doctor.relations.clocks import clock_terms
from identification.doctor.relations.pairing import MOVES, Pairing, pairings
from identification.doctor.relations.relation import Relation, off
from identification.doctor.statistics import slope, spread, travel

SLOPE = 0.012
"""Camera over encoders: elastic cables make it 1.001 to 1.003."""

GIVE = 0.001
"""What cables, play and friction take of a motion [m], over which a slope goes with it."""

TOGETHER = 0.9
"""Correlation from which camera and encoders have a slope."""

APART = 0.5
"""Correlation below which they have nothing to do with each other."""

UNRELATED = 1e4
"""Factor that this counts as: a slip that hides another one's slope mends less than both."""

START = 0.010
"""Camera minus [initial] [m], the median of the runs; one run alone reaches 4 mm."""

OFFSET = 0.005
"""Error of a stated clock [s]; good campaigns reach 0.3 ms, one run 1.7 ms."""

DRIFT = 0.0015
"""Rate of a clock's error; one elastic run alone is biased by 0.0009."""

SPANS = 1.6
"""Length of the camera's stream over the drive's."""

OUTSIDE = 0.03
"""Share of the places that may be outside the frame."""

PERIODS = (5e-4, 0.5)
"""Frame periods [s] that there are."""

LEAN = 2.6
"""Factor of the rotation over the line between the carriages: good ones, 0.97 to 1.19."""

RINGING = 8.0
"""The same where nothing but knocks tells it."""

FIRM = 0.8
"""Correlation from which rotation and line go together in knocks, too."""

FAR = 0.15
"""Travel of a run [m] that neither a knock nor the cable's elasticity gives."""

TRAVEL = 1.3
"""Factor of the camera's travel over the encoders'."""

LINE = 1.5
"""Factor of x_e over the line between the carriages; it lags while it accelerates."""


def camera_relations(case: Case) -> Iterator[Relation]:
    """What the camera says of the encoders, the frame and the drive's clock.

    Args:
        case: The campaign, unstated clocks estimated.

    Yields:
        The relations that these runs have, the cheap ones first.
    """
    if not case.filmed:
        return
    yield from _stream_relations(case)
    yield from _start_relations(case)
    pairs = pairings(case)
    moving = [pair for pair in pairs if pair.moves]
    if moving:
        yield _residual(moving)
        yield from _travel(moving)
        yield from _slopes(moving)
        yield from _carriages(moving)
        yield from _line(moving, case)
        yield from _height(moving, case)
    yield from _rotation(pairs, case)
    if moving:
        yield from _clock(case, len(moving))


def _stream_relations(case: Case) -> list[Relation]:
    film = case.filmed
    period = float(np.median([np.median(np.diff(record.frame_time)) for record in film]))
    spans = [math.log(np.ptp(record.frame_time) / np.ptp(record.time)) for record in film]
    span = math.exp(float(np.median(spans)))
    inside = float(np.median([_overlap(record) for record in film]))
    share = _outside(case)
    return [
        Relation(
            name="period.camera",
            excess=max(period / PERIODS[1], PERIODS[0] / period),
            what=f"the camera's frame period is {period:.4g} s",
            figures={"period_s": period},
        ),
        Relation(
            name="spans",
            excess=off(span, SPANS),
            what=f"the camera's stream is {span:.4g} times as long as the drive's",
            figures={"ratio": span},
        ),
        Relation(
            name="overlap",
            # Streams without a common time say nothing of each other, which is no relief.
            excess=0.5 / max(inside, 1e-7),
            what=f"{inside:.0%} of the frames are within the drive's time",
            figures={"share": inside},
        ),
        Relation(
            name="frame",
            excess=share / OUTSIDE,
            what=f"{share:.0%} of the places are outside the frame",
            figures={"share": share},
        ),
    ]


def _overlap(record: Record) -> float:
    """Share of the shorter stream's time in which there is the other one."""
    time = record.frame_time - record.offset
    common = min(time[-1], record.time[-1]) - max(time[0], record.time[0])
    return max(float(common), 0.0) / float(min(np.ptp(time), np.ptp(record.time)))


def _outside(case: Case) -> float:
    shares = []
    for record in case.filmed:
        for column, size in ((X, case.rig.width), (Y, case.rig.height), (Q3, case.rig.width)):
            places = record.position[:, column]
            if np.isfinite(places).any():
                shares.append(float(np.mean((places < -0.01) | (places > size + 0.01))))
    return float(np.mean(shares)) if shares else 0.0


def _start_relations(case: Case) -> list[Relation]:
    found = []
    for column, name in ((X, "x_e"), (Y, "y_e")):
        away = [
            float(np.nanmedian(record.position[:5, column])) - getattr(record.initial, name)
            for record in case.filmed
            if record.initial is not None and np.isfinite(record.position[:5, column]).any()
        ]
        if away:
            middle = float(np.median(np.abs(away)))
            found.append(
                Relation(
                    name=f"start.{name}",
                    excess=middle / START,
                    what=f"camera {name} begins {middle * 1e3:.3g} mm off [initial]",
                    figures={"off_m": away},
                )
            )
    return found


def _residual(moving: Sequence[Pairing]) -> Relation:
    """Camera minus encoders, run by run, over what elasticity and noise allow."""
    off_by, shares = [], []
    for pair in moving:
        lower, _, height = residuals(pair)
        worst = 1.25 * max(float(np.mean(np.abs(lower))), float(np.mean(np.abs(height))))
        moved = max(travel(pair.position[:, Q3]), travel(pair.position[:, Y]))
        off_by.append(worst)
        shares.append(worst / (0.003 + 0.004 * moved))
    middle = float(np.median(off_by))
    return Relation(
        name="camera over encoders",
        excess=float(np.median(shares)),
        what=f"camera and encoders differ by {middle * 1e3:.3g} mm",
        figures={"off_m": off_by},
    )


def _travel(moving: Sequence[Pairing]) -> list[Relation]:
    """How far the robot goes by the camera, over how far by the encoders.

    It knows neither signs nor which encoder is which, so that a factor is told beside such a
    slip; and no factor can pass by making the encoders stand still.
    """
    ratios = []
    for pair in moving:
        seen = math.hypot(travel(pair.position[:, Q3]), travel(pair.position[:, Y]))
        turned = math.hypot(travel(pair.along), travel(pair.up))
        if max(seen, turned) > FAR:
            ratios.append(math.log(max(seen, 1e-6) / max(turned, 1e-6)))
    if not ratios:
        return []
    ratio = math.exp(float(np.median(ratios)))
    return [
        Relation(
            name="travel",
            excess=off(ratio, TRAVEL),
            what=f"by the camera the robot goes {ratio:.4g} times as far as by the encoders",
            figures={"ratio": ratio},
        )
    ]


def residuals(pair: Pairing) -> tuple[Float64[np.ndarray, " _"], ...]:
    """Camera minus encoders of a run, each about its median.

    Args:
        pair: The run.

    Returns:
        Lower carriage, upper carriage and height [m], without lost markers.
    """
    left = []
    for column, base in ((Q3, pair.along), (Q4, pair.along), (Y, pair.up)):
        error = pair.position[:, column] - base
        error = error[np.isfinite(error)]
        left.append(error - np.median(error) if len(error) > 5 else np.zeros(1))
    return tuple(left)


def _slopes(moving: Sequence[Pairing]) -> list[Relation]:
    found = []
    for axis, column, name in (("x", Q3, "q_3"), ("y", Y, "y_e")):
        pairs = [
            (pair.along if axis == "x" else pair.up, pair.position[:, column])
            for pair in moving
        ]
        farthest = max(travel(base) for base, _ in pairs)
        fit = slope(pair for pair in pairs if travel(pair[0]) > MOVES)
        if fit is not None and abs(fit.correlation) > TOGETHER:
            allowed = 1 + SLOPE + GIVE / farthest
            ratio = fit.value if fit.value > 0 else UNRELATED
            what = f"slope {fit.value:.4f} ± {fit.sigma:.1g} in {len(pairs)} runs"
        elif _strangers([pair for pair in pairs if max(map(travel, pair)) > FAR]):
            allowed, ratio = 1 + SLOPE, UNRELATED
            what = "one moves without the other"
        else:
            continue
        found.append(
            Relation(
                name=f"slope.{axis}",
                excess=off(ratio, allowed),
                what=f"camera {name} over encoder {axis}: {what}",
                figures={} if fit is None else {"slope": fit.value, "sigma": fit.sigma},
            )
        )
    return found


def _strangers(pairs: Sequence[tuple[Float64[np.ndarray, " _"], ...]]) -> bool:
    """Whether two signals, one of which goes far, have nothing to do with each other."""
    if not pairs:
        return False
    fit = slope(pairs)
    return fit is None or abs(fit.correlation) < APART


def _clock(case: Case, moving: int) -> list[Relation]:
    terms = clock_terms(case)
    if terms is None or abs(terms.scale - 1) > 0.1:
        return []
    offset = Relation(
        name="clock.offset",
        excess=abs(terms.offset) / (OFFSET + terms.offset_error),
        what=f"the camera's clock is {terms.offset * 1e3:.3g} ms off what is stated",
        figures={"offset_s": terms.offset},
    )
    drift = Relation(
        name="clock.drift",
        # One elastic run alone can't tell a drift from its cable.
        excess=abs(terms.drift) / (DRIFT + terms.drift_error) if moving > 1 else 0.0,
        what=f"the camera's clock gains {terms.drift * 1e3:.3g} ms a second",
        figures={"rate": terms.drift},
    )
    return [offset, drift]


def _carriages(moving: Sequence[Pairing]) -> list[Relation]:
    """Which of the two carriages the drives move."""
    sizes = [
        [math.sqrt(float(np.mean(np.square(error)))) for error in residuals(pair)[:2]]
        for pair in moving
    ]
    ratios = [math.log(max(a, 1e-6) / max(b, 1e-6)) for a, b in sizes if max(a, b) > 0.004]
    if not ratios:
        return []
    ratio = float(np.median(ratios))
    return [
        Relation(
            name="carriages",
            excess=1 + min(ratio + 0.2, 3.0) if ratio > -0.2 else 0.5,
            what=f"q_3 follows the encoders {math.exp(ratio):.2g} times as badly as q_4",
            figures={"ratio": math.exp(ratio)},
        )
    ]


def _line(moving: Sequence[Pairing], case: Case) -> list[Relation]:
    """The end-effector hangs between the carriages: x_e over the line through them."""
    pairs = [(_between(pair, case.rig.height), pair.position[:, X]) for pair in moving]
    fit = slope(pair for pair in pairs if travel(pair[0]) > 10 * MOVES)
    if fit is None or abs(fit.correlation) < 0.8:
        return []
    ratio = max(fit.value, 1e-3)
    return [
        Relation(
            name="slope.x_e",
            excess=off(ratio, LINE),
            what=f"camera x_e over the line between the carriages: slope {fit.value:.4f}",
            figures={"slope": fit.value, "sigma": fit.sigma},
        )
    ]


def _between(pair: Pairing, height: float) -> Float64[np.ndarray, " frames"]:
    lower, upper = pair.position[:, Q3], pair.position[:, Q4]
    return lower + (upper - lower) * pair.position[:, Y] / height


def _height(moving: Sequence[Pairing], case: Case) -> list[Relation]:
    """Near the upper carriage the end-effector follows it, near the lower one the other.

    That alone tells an upside-down camera from exchanged drives where no [initial] is.
    """
    pairs = []
    for pair in moving:
        lean = pair.position[:, Q4] - pair.position[:, Q3]
        if spread(lean) > 5 * case.rig.position_sigma:
            share = pair.position[:, Y] / case.rig.height - 0.5
            pairs.append((lean * share, pair.position[:, X] - pair.position[:, Q3] - lean / 2))
    fit = slope(pairs)
    if fit is None or fit.sigma > 0.1 or abs(fit.value) < 6 * fit.sigma:
        return []
    return [
        Relation(
            name="height",
            excess=1.5 if -1.5 < fit.value < -0.1 else 0.0,
            what=f"x_e follows the carriages with the height by {fit.value:.3g}, not 0 to 1",
            figures={"slope": fit.value, "sigma": fit.sigma},
        )
    ]


def _rotation(pairs: Sequence[Pairing], case: Case) -> list[Relation]:
    """The end-effector turns with the line between the carriages."""
    calm = [pair for pair in pairs if pair.record.kind != "pseudo_impulse"]
    fit = slope(
        (
            (pair.position[:, Q3] - pair.position[:, Q4]) / case.rig.height,
            pair.position[:, D],
        )
        for pair in calm or pairs
    )
    if fit is None:
        return []
    sure = abs(fit.value) > 6 * fit.sigma and fit.sigma < 0.12 * max(1.0, abs(fit.value))
    # A knocked end-effector rings about the line by itself.
    rings = not calm and abs(fit.correlation) < FIRM
    ratio = abs(fit.value) if rings else max(fit.value, 1e-3)
    return [
        Relation(
            name="rotation",
            excess=off(ratio / 1.05, RINGING if rings else LEAN) if sure else 0.5,
            what=f"rotation over the line between the carriages: slope {fit.value:.4g} ± "
            f"{fit.sigma:.1g}",
            figures={"slope": fit.value, "sigma": fit.sigma},
        )
    ]
