"""What is told of a motor-driven axis."""
