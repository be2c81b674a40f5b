"""Logged runs as arrays, with their clocks and start poses."""
