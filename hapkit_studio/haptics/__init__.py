"""The real-time side: the one tick, the loops that drive it, and what passes between loop and window."""
