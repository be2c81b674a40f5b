"""What an entry point sets up, and who computes what takes long: units, executors, a store."""

from .aside import processes_aside as processes_aside
from .entry_point import set_up as set_up
from .entry_point import shown_progress as shown_progress
