"""The cell as its owner wrote it: robot, pod, tote, devices, items, limits and named configurations."""
