"""Device events bound to the path: made, resolved to times, fired by measured progress."""
