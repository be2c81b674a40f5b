"""Input shapers: the catalogue, and shapers designed for modes or a measured spectrum."""
