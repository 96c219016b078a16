"""Where the tool is and how to get it there: chains of the kernel, inverse kinematics, straight lines."""
