"""The second opinion: checks a plan with code that shares only ``cell`` and ``motion`` with the planner."""
