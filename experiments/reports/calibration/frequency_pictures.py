"""The report's pictures of natural frequencies: the map, the heights, the decays."""

from collections.abc import Iterator

from experiments.figures.identification.frequency_map import (
    frequency_map,
    frequency_over_height,
)
from experiments.figures.identification.ring_down import ring_down_figure
from experiments.page.number_text import percent, plain
from experiments.page.page import Picture, Pictures
from experiments.studies.findings.findings import Findings
from identification.knocks.frequency_map import FrequencyMap
from scdpr_jax.robot.quantities import value


def frequency_pictures(findings: Findings, picture: Pictures) -> Iterator[Picture]:
    """The pictures.

    Args:
        findings: What a calibration comes to; it has frequencies.
        picture: The page's figures.

    Yields:
        Each of them.
    """
    frequencies, robot = findings.frequencies, findings.estimate.robot
    frame = tuple(float(value(robot, f"frame_{side}")) for side in ("width", "height"))
    settings = sorted(set(frequencies.pretension.tolist()))
    yield picture(
        frequency_map(frequencies, findings.model_curves, size=frame, settings=settings),
        "The lowest natural frequency over the workspace by the fitted model, both carriages "
        "held by friction, and the knocks on it in the same colours: a mark that can't be told "
        "from its ground is explained. Beside a knock: its frequency, and by how much the "
        "model is above (+) or below (−). A square: the carriages were still sliding, so that "
        "the frequency depends on the amplitude.",
        seen=f"A map of the frame. {_knocks(frequencies)}",
        narrow=True,
    )
    yield picture(
        frequency_over_height(frequencies, findings.model_curves),
        "The same over the height. Points on a curve: the pretension that the motion asks for "
        "also explains the vibration. Points off both curves: something else holds the "
        "carriages, or the model lacks a compliance.",
        seen=f"Frequencies over the height of the end-effector. {_knocks(frequencies)}",
        narrow=len(settings) == 1,
    )
    for decay in findings.decays:
        first = decay.ring_down.modes[0]
        yield picture(
            ring_down_figure(decay),
            f"Run {decay.run}: the free vibration after the knock, and its spectrum with the "
            "fitted frequency (solid) and the highest peak (dotted). The red line should go "
            "through the dots.",
            seen=f"A vibration of {plain(decay.ring_down.frequency, 4)} Hz that decays with a "
            f"damping ratio of {percent(first.damping_ratio)}, camera and fitted curve, and "
            "its spectrum.",
        )


def _knocks(frequencies: FrequencyMap) -> str:
    told = "; ".join(
        f"{plain(float(f), 3)} Hz at x {1e3 * x:.0f}, y {1e3 * y:.0f} mm, {tension:g} N"
        for f, x, y, tension in zip(
            frequencies.frequency,
            frequencies.x,
            frequencies.y,
            frequencies.pretension,
            strict=True,
        )
    )
    return f"Knocked: {told}."
