"""CSV and its relatives: how the text is written, found where nobody says it."""
