"""Every slip that people make is found, and named first."""

import tracemalloc

import loose_rig
import numpy as np
import planted_slips
import pytest

from identification.doctor import Finding, examine
from identification.doctor.slips.scales import companions

QUICK = (
    "degrees labelled rad",
    "delta in degrees",
    "mm labelled m",
    "mV labelled V",
    "drive ms as s",
    "both s as ms",
    "rate of 800",
    "motor 2",
    "voltage 1",
    "alpha 2",
    "x leftwards",
    "y downwards",
    "delta reversed",
    "motors",
    "carriages",
    "motor side of one",
    "camera 3 %",
    "offset of 12 ms",
    "drift of 0.3 %",
    "wraps at a turn",
    "jump of 0.1 rad",
    "stuck angle",
    "stuck volts",
    "stuck q_3",
    "lost as 0",
    "lost as the last",
    "other marker",
    "drive gap",
    "camera gap",
    "clock jump",
    "no knock",
    "knock at 0.75 s",
    "cut start",
    "step labelled knock",
    "knock labelled step",
    "same run twice",
    "before the limit",
    "nothing moves",
    "start outside",
    "degrees in one run",
    "counts labelled rad",
    "alpha 2 in one run",
    "motor 1 in one run",
    "encoder 1 in degrees in one run",
    "voltage 1 in one run",
    "mV in one run",
    "q_4 in cm as m",
    "jump of 0.1 rad at 200 Hz",
    "volts stuck at 3",
)
"""At least one of each way of telling; the others are in the slow suite."""


def identifiers(findings: tuple[Finding, ...], wanted: str) -> list[str]:
    """Identifiers in their order, without the true note that knocks aren't stated."""
    return [f.id for f in findings if f.id != "knock.missing" or f.id == wanted]


@pytest.mark.parametrize(
    "slip",
    [
        pytest.param(slip, marks=[pytest.mark.slow] if number % 4 else [])
        for number, slip in enumerate(QUICK)
    ],
)
def test_a_slip_is_named_first(good, slip):
    wanted, plant = planted_slips.PLANTED[slip]
    campaign = good[1]  # states its knocks, its starts and its clock
    found = identifiers(examine(plant(campaign, np.random.default_rng(3))), wanted)
    assert found[0] == wanted


@pytest.mark.slow
def test_two_slips_are_unravelled(good):
    random = np.random.default_rng(0)
    campaign = good[1]
    for slip in ("degrees labelled rad", "y downwards"):
        campaign = planted_slips.PLANTED[slip][1](campaign, random)
    found = examine(campaign)
    assert {finding.id for finding in found} >= {"unit.alpha", "sign.y_e"}


@pytest.mark.slow
def test_nearly_every_slip_is_found_on_rigs_that_were_not_seen():
    random = np.random.default_rng(20)
    total, found, first = 0, 0, 0
    for campaign in loose_rig.campaigns(list(range(5000, 5020))):
        for wanted, plant in planted_slips.PLANTED.values():
            if not planted_slips.applies(wanted, campaign):
                continue
            ids = identifiers(examine(plant(campaign, random)), wanted)
            total += 1
            found += wanted in ids
            first += ids[:1] == [wanted]
    assert found >= 0.995 * total
    assert first >= 0.99 * total


PAIRS = (
    ("degrees labelled rad", "y downwards"),
    ("mm labelled m", "alpha 1"),
    ("motors", "delta in degrees"),
    ("offset of 0.2 s", "alpha 2"),
    ("mV labelled V", "x leftwards"),
    ("rate doubled", "delta reversed"),
    ("wraps at a turn", "voltage 2"),
    ("drive ms as s", "y negative"),
    ("camera ms as s", "alphas"),
    ("counts by four", "voltages"),
    ("counts by four", "motor 2"),
    ("radius is diameter", "y_e in cm"),
)
"""Pairs that don't cancel."""


@pytest.mark.parametrize(
    ("factor", "also"),
    [
        (26.0, ()),  # a gearbox
        (0.25, ()),
        (26 / np.rad2deg(1), ("unit.alpha",)),  # and degrees
        (2.06, ("scale.camera",)),  # a diameter, and a camera that is off by 3 %
        (1.03, ()),
    ],
)
def test_a_factor_that_may_be_two_slips_names_the_other(factor, also):
    assert companions(factor) == also


@pytest.mark.slow
def test_pairs_of_slips_are_unravelled():
    random = np.random.default_rng(21)
    pairs, both = 0, 0
    for campaign in loose_rig.campaigns(list(range(5100, 5104))):
        for slips in PAIRS:
            slipped = campaign
            for slip in slips:
                slipped = planted_slips.PLANTED[slip][1](slipped, random)
            ids = {finding.id for finding in examine(slipped)}
            pairs += 1
            both += ids >= {planted_slips.PLANTED[slip][0] for slip in slips}
    assert both >= 0.9 * pairs


@pytest.mark.slow  # allocations are counted, in every call that is checked
def test_a_search_holds_a_few_copies_of_the_log_and_not_one_a_slip(good):
    random = np.random.default_rng(0)
    campaign = good[1].with_runs([run.name for run in good[1].runs[::3]])
    for slip in ("degrees labelled rad", "y downwards"):  # so that pairs are sought as well
        campaign = planted_slips.PLANTED[slip][1](campaign, random)
    drives = (run.drive for run in campaign.runs)
    log = sum(each.time.nbytes + each.voltage.nbytes + each.angle.nbytes for each in drives)
    tracemalloc.start()
    try:
        examine(campaign)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # 5.4 logs; a case for each slip of the catalogue made 31 of them.
    assert peak < 12 * log
