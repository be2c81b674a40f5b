"""How well each channel is explained, and which quantities are told only together."""

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from experiments.page.coordinates import COORDINATES, plain_symbol
from experiments.page.heat import Cell, Heat, Row, shade
from experiments.page.number_text import plain
from identification.fit.comparison import NOISE_LIMIT, Channel, Comparison
from scdpr_jax.robot.quantities import EVERY_QUANTITY

_MISFIT = ("#f4f8fb", "#f6c177", "#b5400a", "#4a1200")
_SIGN = ("#0072b2", "#a9d1ea", "#ffffff", "#f3c39b", "#b04a00")
_LARGEST = 100.0
"""Times the noise from which on the colour stays [1]."""
_STRONG = 0.9
"""Correlation from which on two quantities are hardly told apart [1]."""


def misfit_heat(comparisons: Sequence[Comparison]) -> Heat:
    """What is left of each run's channels, in times of the sensor's noise.

    Args:
        comparisons: The runs.

    Returns:
        The table; a channel that has more than noise is bold and framed.
    """
    limits = {kind: plain(math.sqrt(most)) for kind, most in NOISE_LIMIT.items()}
    return Heat(
        "Residuals of each channel, root mean square over the noise of the sensor. About 1 "
        f"is noise alone (up to {limits['camera']} for the camera, {limits['encoder']} for an "
        "encoder, which rounds). Bold and framed: more than noise, look at that run below.",
        tuple(coordinate.symbol for coordinate in COORDINATES.values()),
        tuple(
            Row(
                f"{run.name} (not fitted)" if run.held_out else run.name,
                _channels(run.channels),
                flagged=run.held_out,
            )
            for run in comparisons
        ),
    )


def _channels(channels: Sequence[Channel]) -> tuple[Cell, ...]:
    by_name = {channel.name: channel for channel in channels}
    return tuple(
        _misfit(by_name[name]) if name in by_name else Cell("–") for name in COORDINATES
    )


def _misfit(channel: Channel) -> Cell:
    times = math.sqrt(channel.chi_square)
    share = math.log(max(times, 1.0)) / math.log(_LARGEST)
    return Cell(plain(times), shade(share, _MISFIT), strong=not channel.is_noise)


def quantity_symbols(quantities: Sequence[tuple[str, str | None]]) -> tuple[str, ...]:
    """Quantities in as few letters as tell them apart.

    Args:
        quantities: Their names in the file formats, and the nominal pretensions that they
            belong to, if they do.

    Returns:
        "T 350 N"; the name in words where two have the same symbol, as the paper's b is both a
        length and a damping.
    """
    symbols = [_symbol(*quantity) for quantity in quantities]
    return tuple(
        symbol if symbols.count(symbol) == 1 else name.replace("_", " ")
        for symbol, (name, _) in zip(symbols, quantities, strict=True)
    )


def _symbol(name: str, setting: str | None) -> str:
    kind = {quantity.name: quantity for quantity in EVERY_QUANTITY}.get(name)
    symbol = "".join(plain_symbol(kind.symbol)) if kind else name.replace("_", " ")
    return f"{symbol} {setting}" if setting else symbol


def correlation_heat(
    names: Sequence[str], matrix: Float[np.ndarray, "n n"], *, whose: str = "the estimates"
) -> Heat:
    """A correlation matrix.

    Args:
        names: What the rows are called, shortly.
        matrix: Correlations [1].
        whose: What is correlated.

    Returns:
        Its lower half in hundredths; from 0.9 on they are bold and framed.
    """
    empty = Cell("")
    return Heat(
        f"Correlation of {whose}, in hundredths. Near ±100 (bold, framed) the data tell only a "
        "combination of the two, such as the product of friction and pretension.",
        tuple(names),
        tuple(
            Row(
                name,
                (
                    *(_correlation(float(matrix[row, column])) for column in range(row)),
                    Cell("1", "#ececec"),
                    *(empty for _ in range(row + 1, len(names))),
                ),
            )
            for row, name in enumerate(names)
        ),
    )


def _correlation(value: float) -> Cell:
    text = f"{100 * value:+.0f}".replace("-", "−")
    return Cell(
        "0" if text in ("+0", "−0") else text,
        shade(0.5 + 0.5 * value, _SIGN),
        strong=abs(value) >= _STRONG,
    )
