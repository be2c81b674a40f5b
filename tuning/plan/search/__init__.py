"""The search for a motion that suits robots as they might be."""
