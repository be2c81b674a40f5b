"""The loop's cable, its creep and the actuator that keeps its tension: Figure 21."""

from experiments.paper.topics.tensioning.section import SECTIONS as SECTIONS
