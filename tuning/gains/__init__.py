"""Gains and shapers through the simulated closed loop."""
