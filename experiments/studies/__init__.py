"""What the verbs compute."""
