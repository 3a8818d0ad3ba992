"""Shared widgets: theme, style, icons, number fields, switches."""
