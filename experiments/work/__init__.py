"""Long computations in independent units: who computes them, and what is kept of them."""
