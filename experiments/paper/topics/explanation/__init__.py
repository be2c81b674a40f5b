"""The topic `explanation`."""
