"""What the verbs compute, and what it comes to; nothing here prints or draws."""
