"""Online queries: plan_pick and plan_move, from a scene to a proven, timed plan with its events."""
