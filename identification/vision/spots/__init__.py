"""Marks and markers in a picture: coloured discs and tags, to a few hundredths of a pixel."""
