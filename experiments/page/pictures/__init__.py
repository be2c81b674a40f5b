"""Figures as they stand in a page: cut into panels, in the page's colours, drawn aside."""
