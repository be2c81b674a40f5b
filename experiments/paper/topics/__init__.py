"""The paper's topics, each with its numbers, figure, section and claims."""
