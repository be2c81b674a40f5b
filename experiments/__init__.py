"""What people run: the command `scdpr`, and the studies, reports and figures behind it."""
