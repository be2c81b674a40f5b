"""What a report has of gains and shapers."""
