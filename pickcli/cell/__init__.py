"""What stands where: the cell, its robot, pod, tote, devices and items, and scenes of it."""
