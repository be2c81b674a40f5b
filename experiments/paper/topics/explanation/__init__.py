"""Which parameters explain all reported results at once, and what is left."""

from experiments.paper.topics.explanation.section import SECTIONS as SECTIONS
