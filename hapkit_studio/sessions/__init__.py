"""Sessions: recordings of runs that can be saved, read and exported."""
