"""What smoothed friction does to what is identified: our own `docs/validity.md`, judged."""

from experiments.paper.topics.smoothing.section import SECTIONS as SECTIONS
