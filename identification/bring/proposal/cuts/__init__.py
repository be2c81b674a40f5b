"""Which logs are one recording, where it rests, and what kind of run each part is."""
