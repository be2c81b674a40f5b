"""Verbs that learn from logs."""
