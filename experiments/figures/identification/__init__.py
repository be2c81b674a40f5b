"""Figures of fits, runs and knocks."""
