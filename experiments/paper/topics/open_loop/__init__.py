"""The topic `open_loop`."""
