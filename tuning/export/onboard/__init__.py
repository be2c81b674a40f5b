"""Legs planned in the controller: `export/onboard/`."""
