"""Vectorised sweeps of the workspace and of parameters: `scdpr sweep`."""
