"""What a person says of logs: which channel is what, in which unit, on which clock."""
