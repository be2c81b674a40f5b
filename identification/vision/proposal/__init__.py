"""A `VISION.toml` for a video of which nothing is known but the video."""

from identification.vision.proposal.propose import Proposal as Proposal
from identification.vision.proposal.propose import propose as propose
