"""The real-time side: the tick, the loops that drive it, and the data that loop and window exchange."""
