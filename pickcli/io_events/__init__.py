"""Device events on a path: binding, resolution to times, and firing by measured progress.

Read `bind`, then `resolve`; `event_binding` does both for a pick. `tracker` fires events during execution.
"""
