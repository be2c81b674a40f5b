"""What the paper is about, a folder each: numbers, figure, section of the report, claims."""
