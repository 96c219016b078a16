"""One file per subcommand: parse, call one library function, report. No algorithm inside.

Read `main`, then any command, e.g. `plan_pick`; `options` and `report` are what all share.
"""
