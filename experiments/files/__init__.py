"""Files that the verbs read and write."""
