"""The topic `loop`."""
