"""What a fit is checked by: other models, other runs, the whole likelihood."""
