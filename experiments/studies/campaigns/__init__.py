"""Many campaigns identified in one call, each a unit: `scdpr identify A B C …`."""
