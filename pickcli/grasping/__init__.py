"""Where a suction cup may sit on an item, and whether it would hold there."""
