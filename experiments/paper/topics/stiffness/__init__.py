"""How stiff both robots are over the workspace: the claim of section 7."""

from experiments.paper.topics.stiffness.section import SECTIONS as SECTIONS
