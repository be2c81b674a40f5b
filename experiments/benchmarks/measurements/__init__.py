"""What is measured: runs, Jacobians, fits, frequencies, cold starts."""
