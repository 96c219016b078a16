"""Planners compared on the same queries: entries, runs, and a summary of both."""
