"""The robot: its parameters, geometry, cable, friction, drives and equations of motion."""
