"""Printers of results: in the terminal, as a page, as files. None computes what it prints."""
