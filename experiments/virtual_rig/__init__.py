"""Robots of known truth, and the campaigns of logs that they leave."""
