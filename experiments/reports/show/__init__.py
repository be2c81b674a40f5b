"""Results of a folder on this machine's own address: pages, films, plans to try."""
