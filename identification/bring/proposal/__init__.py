"""The mapping that logs seem to ask for, from names, units and signals, with a reason each."""
