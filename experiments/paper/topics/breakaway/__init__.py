"""The topic `breakaway`."""
