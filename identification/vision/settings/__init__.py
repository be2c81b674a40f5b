"""`VISION.toml`: what is said of a video of the rig."""

from identification.vision.settings.document import Mark as Mark
from identification.vision.settings.document import Marker as Marker
from identification.vision.settings.document import Vision as Vision
from identification.vision.settings.faults import VisionError as VisionError
from identification.vision.settings.read import read_vision as read_vision
