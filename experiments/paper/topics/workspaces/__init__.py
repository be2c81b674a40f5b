"""The conventional robot's workspace beside the single loop's: Figures 3 and 6."""

from experiments.paper.topics.workspaces.section import SECTIONS as SECTIONS
