"""What XLA calls, and how it describes what it calls with."""
