"""The run that would tell the most."""
