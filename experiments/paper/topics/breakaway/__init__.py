"""What voltage sets the robot off: Figure 10 and section 5.1."""

from experiments.paper.topics.breakaway.section import SECTIONS as SECTIONS
