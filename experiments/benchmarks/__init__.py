"""Error beside speed, for this engine and its peers: `scdpr benchmark`."""
