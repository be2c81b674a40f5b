"""What is stated of a robot, without JAX: its quantities, units and numbers."""
