"""Robots whose lower carriage and height are led: what the rest of them does."""
