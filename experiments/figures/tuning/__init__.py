"""Figures of loops, shapers and legs."""
