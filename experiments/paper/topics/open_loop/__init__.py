"""A second of torque from four poses: Table 2 with Figures 13 and 14, section 5.3."""

from experiments.paper.topics.open_loop.section import SECTIONS as SECTIONS
