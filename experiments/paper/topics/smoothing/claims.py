"""What `docs/validity.md` says of smoothed friction, held to what it does to a fit."""

import numpy as np

from experiments.paper.claim import Claim, Verdict, at_least, at_most, within
from experiments.paper.topics.smoothing.numbers import WANTED, smoothing

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "smoothing",
        "docs/validity.md",
        "bias of the fitted μ vanishes in proportion to the width: power of the width",
        "1",
        "1",
        within(1.0, 0.2),
        "a fifth: the time that a smoothed carriage takes to stop has a logarithm of the width",
        lambda: smoothing().order,
        Verdict.REPRODUCED,
        heavy=True,
    ),
    Claim(
        "smoothing",
        "docs/validity.md",
        "bias of the fitted μ at the default width",
        f"{100 * WANTED:g}",
        "%",
        at_most(100 * WANTED),
        "what a fit on good logs is to reach",
        lambda: 100 * abs(float(smoothing().default.bias[0])),
        Verdict.NOT_REPRODUCIBLE,
        "smoothed friction is another model; fits are made with the exact engine",
        heavy=True,
    ),
    Claim(
        "smoothing",
        "docs/validity.md",
        "bias of any unknown in the exact engine's fit, steps five times the truth's",
        "0",
        "1",
        at_most(1e-6),
        "a thousandth of what is wanted",
        lambda: float(np.abs(smoothing().exact[-1].bias).max()),
        Verdict.REPRODUCED,
        heavy=True,
    ),
    Claim(
        "smoothing",
        "docs/validity.md",
        "exact engine's derivatives against central differences, over the largest",
        "equal",
        "1",
        at_most(1e-5),
        "a hundredth of what is wanted of μ",
        lambda: smoothing().difference,
        Verdict.REPRODUCED,
        heavy=True,
    ),
    Claim(
        "smoothing",
        "docs/validity.md",
        "error of the smoothed derivative by μ, carriages held over sliding, default width",
        "larger",
        "1",
        at_least(1.0),
        "the other way round it would be larger while they slide",
        lambda: smoothing().default.held / smoothing().default.sliding,
        Verdict.REPRODUCED,
        heavy=True,
    ),
)
"""Claims on smoothed friction."""
