"""How far each column may be off."""

from identification.vision.uncertainty.sigma import Sigma as Sigma
from identification.vision.uncertainty.sigma import sigma_of as sigma_of
