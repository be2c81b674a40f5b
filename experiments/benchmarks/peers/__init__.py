"""What is measured beside each other."""
