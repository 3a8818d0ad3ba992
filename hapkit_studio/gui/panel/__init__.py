"""The panel on the right: environment and parameters, loop, renderer, stability."""
