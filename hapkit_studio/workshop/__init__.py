"""Environments that a user writes: their folder and templates, the list of trusted files, and trial runs."""

from hapkit_studio.workshop.reading import load

load_environment = load
__all__ = ["load", "load_environment"]
