"""What is worth noting of a run that can be read."""
