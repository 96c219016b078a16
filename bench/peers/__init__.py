"""Planners of others on our queries: ``make bench-peers``. See ``bench/peers/__main__.py``."""
