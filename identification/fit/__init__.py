"""Residuals of all runs at once, their normal equations, and where a fit begins."""
