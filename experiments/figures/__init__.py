"""The figures of the reports, one concept a file; each draws what it is given."""
