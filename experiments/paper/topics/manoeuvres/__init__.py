"""The controlled manoeuvres: Table 3 with Figures 16 to 20, section 6.2."""

from experiments.paper.topics.manoeuvres.section import SECTIONS as SECTIONS
