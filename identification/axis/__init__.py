"""One motor-driven axis with dry friction."""
