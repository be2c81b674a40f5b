"""Numerics that know nothing of a robot."""
