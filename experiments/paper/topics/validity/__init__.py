"""The topic `validity`."""
