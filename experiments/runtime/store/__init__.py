"""What is kept of a long computation on the way, each unit with its checksum."""
