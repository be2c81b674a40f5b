"""Legs planned to arrive at rest."""
