"""The fitted robot."""
