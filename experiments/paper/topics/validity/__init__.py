"""Where the linear model (18) holds, and when the carriages stick."""

from experiments.paper.topics.validity.section import SECTIONS as SECTIONS
