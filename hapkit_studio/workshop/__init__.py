"""Environments that a person writes: their folder, whom to trust, reading, trying out, templates."""

from hapkit_studio.workshop.reading import load

load_environment = load
__all__ = ["load", "load_environment"]
