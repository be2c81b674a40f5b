"""Whether fitted values are plausible beside what is known of the rig otherwise.

That is its nameplate, its settings, and what was measured with other means.
"""

import itertools
import math

from experiments.page.number_text import plain, readable_unit
from identification.campaign.quantities import QuantityError, parse_quantity
from identification.campaign.types import Campaign
from identification.fit.unknowns.measured import MeasuredFit
from identification.fit.unknowns.unknowns import PER_SETTING
from identification.judge.uncertainty import ParameterEstimate
from identification.judge.verdict import INERTIA_FACTOR
from identification.knocks.frequency_map import FrequencyMap
from identification.knocks.settings import ALIKE, APART, alike_settings, odd_knocks
from identification.result.estimate import Estimate
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import value

FACTOR = 5.0
"""Value over the nameplate's, or the reverse, from which it isn't plausible [1]."""

ABOVE = 1.05
"""Effective pretension over its setting from which it isn't plausible [1]: friction and the
cable's give lower it, and nothing raises it but a rough gauge."""

NAMEPLATES = ("drive_inertia", "drive_damping", "friction_coefficient")
"""Quantities that the prototype, or [robot], states a value of."""


def implausible(estimate: Estimate, campaign: Campaign) -> tuple[str, ...]:
    """Fitted values that can hardly be, in words.

    Args:
        estimate: The estimate.
        campaign: The campaign, which may state what the rig has.

    Returns:
        A sentence each.
    """
    prior = estimate.options.prior(campaign)
    sentences = []
    for parameter in estimate.parameters:
        if parameter.status in ("fixed", "unidentifiable", "at_bound"):
            continue
        if parameter.name == PER_SETTING:
            sentences.append(_above_setting(parameter))
        if parameter.name in NAMEPLATES:
            sentences.append(_far_off(parameter, float(value(prior, parameter.name))))
    return tuple(sentence for sentence in sentences if sentence)


def contradiction_sentence(fit: MeasuredFit) -> str:
    """That the logs contradict what was measured otherwise, in words.

    Args:
        fit: The number, and the fit's own.

    Returns:
        The sentence.
    """
    number = fit.measured
    return (
        f"The logs contradict the {number.name.replace('_', ' ')} that was measured otherwise"
        f"{' at ' + number.setting if number.setting else ''}: it is "
        f"{plain(abs(fit.deviation), 2)} of its standard errors off. The fit is a compromise "
        "between both: find out which is wrong."
    )


def ringing_doubts(frequencies: FrequencyMap, robot: Robot) -> tuple[str, ...]:
    """Knocks that don't ring as their settings say, in words.

    Args:
        frequencies: The knocks' natural frequencies.
        robot: The rig's geometry and masses, at any pretension.

    Returns:
        A sentence each.
    """
    sentences = []
    for odd in odd_knocks(frequencies, robot):
        as_another = (
            ""
            if odd.rings_as is None
            else f" They ring as the knocks at {plain(odd.rings_as)} N do."
        )
        sentences.append(
            f"label.pretension: the knocks at {plain(odd.setting)} N don't ring alike. "
            f"{', '.join(odd.runs)}: {plain(odd.ratio, 2)} times the tension of the "
            f"rest.{as_another} Check the label, or whether the tensioner was turned."
        )
    for pair in alike_settings(frequencies, robot):
        low, high = pair.settings
        sentences.append(
            f"label.pretension: the knocks at {plain(low)} N and at {plain(high)} N ring "
            f"alike, {plain(pair.ratio, 3)} times the tension for {plain(high / low, 3)} "
            "times the setting. Check the labels, or whether the tensioner was turned at all."
        )
    return tuple(sentences)


def settings_alike(estimate: Estimate) -> tuple[str, ...]:
    """Settings that the fit finds to be one, in words.

    Args:
        estimate: The estimate.

    Returns:
        A sentence for each pair of neighbouring settings.
    """
    tensions = []
    for parameter in estimate.parameters:
        if parameter.name != PER_SETTING or parameter.status not in ("identified", "weak"):
            continue
        try:
            setting = parse_quantity(parameter.setting or "", unit="N")
        except QuantityError:
            continue
        tensions.append((setting, parameter))
    tensions.sort(key=lambda pair: pair[0])
    sentences = []
    for (low, first), (high, second) in itertools.pairwise(tensions):
        expected, ratio = math.log(high / low), second.value / first.value
        if expected >= APART and abs(math.log(ratio)) < ALIKE * expected:
            sentences.append(
                f"label.pretension: the effective pretension is the same at {first.setting} "
                f"and at {second.setting}, {plain(first.value, 3)} and "
                f"{plain(second.value, 3)} N. Check the labels, or whether the tensioner was "
                "turned at all."
            )
    return tuple(sentences)


def _above_setting(parameter: ParameterEstimate) -> str:
    try:
        setting = parse_quantity(parameter.setting or "", unit="N")
    except QuantityError:
        return ""
    half = parameter.half_width
    low = parameter.value - half if parameter.sigma < float("inf") else parameter.value
    if low <= ABOVE * setting:
        return ""
    return (
        f"Implausible: the effective pretension is {plain(parameter.value, 3)} N at a setting "
        f"of {parameter.setting}. A loop is slacker than it was set, not tauter: check the "
        "commands' unit, the masses, and the setting."
    )


def _far_off(parameter: ParameterEstimate, nameplate: float) -> str:
    if parameter.value <= 0 or nameplate <= 0:
        return ""
    ratio = parameter.value / nameplate
    factor = INERTIA_FACTOR if parameter.name == "drive_inertia" else FACTOR
    if 1 / factor < ratio < factor:
        return ""
    unit = "" if parameter.unit == "1" else f" {readable_unit(parameter.unit)}"
    times = f"{plain(ratio, 2)} times" if ratio > 1 else f"1/{plain(1 / ratio, 2)} of"
    return (
        f"Implausible: the {parameter.name.replace('_', ' ')} is {plain(parameter.value, 3)}"
        f"{unit}, {times} the nameplate's {plain(nameplate, 3)}{unit}. Check the units of "
        "voltages, angles and time, or state the rig's own value in [robot]."
    )
