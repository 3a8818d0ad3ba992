"""Numbers only: the paddle's physics, velocity estimators and the hand."""
