"""Plans of many legs, shared out: `scdpr plan --legs`."""
