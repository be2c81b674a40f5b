"""The topic `tensioning`."""
