"""Verbs that simulate, sweep, measure and compare."""
