"""Logs of other programs, brought into format 1."""
