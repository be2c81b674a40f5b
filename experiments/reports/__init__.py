"""What is told of a result, in the terminal and as a page."""
