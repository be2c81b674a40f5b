"""A fitted robot's co-design, its searches shared out: `scdpr codesign`."""
