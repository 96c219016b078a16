"""Device events on a path: binding, resolution to times, and firing by measured progress.

Read `bind`, then `resolve`; `schedule` does both for a pick. `tracker` fires events during execution.
"""
