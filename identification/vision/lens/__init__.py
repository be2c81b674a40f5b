"""The lens and the marks' plane: what makes a pixel a place."""

from identification.vision.lens.adjusted import Adjusted as Adjusted
from identification.vision.lens.adjusted import adjusted as adjusted
from identification.vision.lens.board import calibrate as calibrate
from identification.vision.lens.lens import Lens as Lens
from identification.vision.lens.plane import Marks as Marks
from identification.vision.lens.plane import fit_plane as fit_plane
from identification.vision.lens.view import View as View
