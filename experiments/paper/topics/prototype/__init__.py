"""What the prototype is made of, and what follows from it: Table 1, section 4."""

from experiments.paper.topics.prototype.section import SECTIONS as SECTIONS
