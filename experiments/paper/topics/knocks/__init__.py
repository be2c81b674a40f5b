"""Knocks and the natural frequency over the workspace: Figures 11 and 12, section 5.2."""

from experiments.paper.topics.knocks.section import SECTIONS as SECTIONS
