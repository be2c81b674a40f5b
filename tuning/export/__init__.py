"""A tuning in the formats of those who run it: C, LabVIEW, MATLAB, python-control."""

from tuning.export.description import Description as Description
from tuning.export.description import describe as describe
from tuning.export.python_control import ControlObjects as ControlObjects
from tuning.export.python_control import control_objects as control_objects
from tuning.export.write import write_exports as write_exports
