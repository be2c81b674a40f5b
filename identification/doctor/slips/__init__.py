"""Slips as changes of a campaign in memory, and the search for the one that explains it."""

from identification.doctor.slips.catalogue import CATALOGUE as CATALOGUE
from identification.doctor.slips.search import conclusion as conclusion
from identification.doctor.slips.slip import Slip as Slip
