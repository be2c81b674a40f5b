"""From a log's channels to a run's streams: numbers in SI units on one clock."""
