"""Verbs that design for the controller."""
