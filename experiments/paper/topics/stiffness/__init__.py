"""The topic `stiffness`."""
