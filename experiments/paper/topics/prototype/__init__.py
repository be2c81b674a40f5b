"""The topic `prototype`."""
