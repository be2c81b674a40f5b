"""What `docs/validity.md` says of smoothed friction, held to what it does to a fit."""

import numpy as np

from experiments.paper.claim import Claim, Printed, at_least, at_most, within
from experiments.paper.topics.smoothing.numbers import WANTED, smoothing

SMOOTHING: tuple[Claim, ...] = (
    Printed(
        "docs/validity.md",
        "1",
        "1",
        within(1.0, 0.2),
        "a fifth: the time that a smoothed carriage takes to stop has a logarithm of the width",
    ).reproduced(
        "bias of the fitted μ vanishes in proportion to the width: power of the width",
        lambda: smoothing().order,
        heavy=True,
    ),
    Printed(
        "docs/validity.md",
        f"{100 * WANTED:g}",
        "%",
        at_most(100 * WANTED),
        "what a fit on good logs is to reach",
    ).not_reproducible(
        "bias of the fitted μ at the default width",
        lambda: 100 * abs(float(smoothing().default.bias[0])),
        "smoothed friction is another model; fits are made with the exact engine",
        heavy=True,
    ),
    Printed(
        "docs/validity.md", "0", "1", at_most(1e-6), "a thousandth of what is wanted"
    ).reproduced(
        "bias of any unknown in the exact engine's fit, steps five times the truth's",
        lambda: float(np.abs(smoothing().exact[-1].bias).max()),
        heavy=True,
    ),
    Printed(
        "docs/validity.md",
        "equal",
        "1",
        at_most(1e-5),
        "a hundredth of what is wanted of μ",
    ).reproduced(
        "exact engine's derivatives against central differences, over the largest",
        lambda: smoothing().difference,
        heavy=True,
    ),
    Printed(
        "docs/validity.md",
        "larger",
        "1",
        at_least(1.0),
        "the other way round it would be larger while they slide",
    ).reproduced(
        "error of the smoothed derivative by μ, carriages held over sliding, default width",
        lambda: smoothing().default.held / smoothing().default.sliding,
        heavy=True,
    ),
)
"""Claims on smoothed friction."""
