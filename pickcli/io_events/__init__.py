"""Device events on a path: binding, resolution to times, and firing by measured progress.

Read `bind`, then `resolve`, then `tracker`.
"""
