"""What steps a robot through time: fixed-grid engines, adaptive solvers, closed loops."""
