"""Kinds of tools: their figures, and how a tool is built from a cell file.

Start with the protocol in `grip_model`, then the kinds: `suction_cup` with `cup_limits` and
`lip_leak`, `gripper` with `pinch_limits`, and `bare_flange`. `tool_builder` builds an arm's tool.
"""
