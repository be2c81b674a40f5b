"""MATLAB's files, version 4 to 7.3: variables by their paths."""
