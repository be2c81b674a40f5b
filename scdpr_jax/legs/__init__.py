"""A leg under a command law, what came of it, and robots as they might be."""
