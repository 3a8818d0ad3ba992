"""Numerical models: the paddle's physics, velocity estimators, integrators, friction and the hand."""
