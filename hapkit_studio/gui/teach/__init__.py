"""Projector, quiz, blind comparison, demos and locks: what an instructor uses."""
