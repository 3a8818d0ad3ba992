"""Environments that a user writes: their folder, trust, reading, trials, templates."""

from hapkit_studio.workshop.reading import load

load_environment = load
__all__ = ["load", "load_environment"]
