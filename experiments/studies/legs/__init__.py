"""Legs as they are planned, compared and logged; many of them, shared out."""
