"""Tools for instructors: projector, quiz, blind comparison, demos and locks."""
