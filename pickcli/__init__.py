"""apc: proven picking motion for a robot arm in front of a shelf."""

__version__ = "0.1.0"
