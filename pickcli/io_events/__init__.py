"""Device events bound to the path: made, resolved to times, and fired by measured progress.

Read `bind`, then `resolve`, then `tracker`.
"""
