"""What collides with what: sphere covers of the robot, boxes of the scene, checks and explanations."""
