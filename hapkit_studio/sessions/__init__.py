"""Sessions: what was felt, kept: recorded, saved afterwards, read back and exported."""
