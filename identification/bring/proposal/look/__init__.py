"""What single columns look like, and which column of the format each seems to be."""
