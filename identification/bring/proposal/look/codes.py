"""Numbers that trackers write where a marker is lost."""

CODES = (0.0, -1.0, -999.0, 999.0, 9999.0, -9999.0, 99999.0, -99999.0, 1e6, -1e6)
"""The numbers."""
