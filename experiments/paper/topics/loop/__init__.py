"""The drive from its step response, and the controller from it: Equations (24) and (25)."""

from experiments.paper.topics.loop.section import SECTIONS as SECTIONS
