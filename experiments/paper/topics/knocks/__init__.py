"""The topic `knocks`."""
