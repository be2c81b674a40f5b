"""How a verb ends, as the shell sees it."""

DONE = 0
"""It did what it was asked to."""
FELL_SHORT = 1
"""It ran, and its result isn't good enough."""
BAD_INPUT = 2
"""It was given what it can't use."""
UNHEARD = 141
"""Whoever read its output has gone."""
STOPPED = 130
"""It was interrupted from the keyboard, as shells number it."""
