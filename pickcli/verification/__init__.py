"""The second opinion: checks a plan; shares only `files`, `cell`, `scene` and `motion` with the planner."""
