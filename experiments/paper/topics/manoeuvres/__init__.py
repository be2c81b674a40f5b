"""The topic `manoeuvres`."""
