"""Exact stick-slip inside a step: one contact, and three on two coordinates."""
