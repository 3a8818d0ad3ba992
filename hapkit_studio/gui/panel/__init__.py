"""The panel at the right: environment and parameters, loop, where the force is computed, stability."""
