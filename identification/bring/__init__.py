"""Logs of other programs, brought into format 1.

`files` reads a log of any make into channels, `mapping` is what a person says these are,
`streams` makes a run's streams of them, `proposal` writes the mapping that it would use.
"""
