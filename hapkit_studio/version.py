"""The version of the studio, as the package metadata states it."""

__version__ = "0.1.0"
