"""What an arm has mounted, by its kind: the figures of each, and how they are made from a cell file.

Read `grip_model`, what every kind states; then the kinds: `suction_cup`, which bears `cup_limits`, `gripper`,
which bears `pinch_limits`, and the `bare_flange`. `tool_builder` makes the tool of an arm from its file.
"""
