"""Force laws: written once in a small subset of Python, checked, and compiled for the loop."""

from hapkit_studio.laws.law import Law, law

__all__ = ["Law", "law"]
