"""Legs as they are planned, compared and logged."""
