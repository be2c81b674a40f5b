"""The paper's figures, drawn from this software's numbers."""
