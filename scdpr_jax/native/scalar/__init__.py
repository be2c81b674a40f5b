"""A step as a program of single numbers: read from its jaxpr, differentiated, made ready."""
