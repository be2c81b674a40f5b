"""Many campaigns identified in one call: `scdpr identify A B C …`."""
