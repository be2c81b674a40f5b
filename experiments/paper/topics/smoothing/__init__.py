"""The topic `smoothing`."""
