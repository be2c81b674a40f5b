"""Every number that the paper prints, with the verdict on it."""

from experiments.reproduce.claims.every import CLAIMS as CLAIMS
from experiments.reproduce.claims.every import of_section as of_section
