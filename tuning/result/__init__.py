"""What tuning gives, and `tuning.json`."""
