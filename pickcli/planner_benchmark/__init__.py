"""Benchmark of planners on the same queries: entries, runs, and a summary.

Read `planner_benchmark`, which runs `benchmark_entries` and the `lattice_entry`, also on `stream_queries`,
and summarises their results in `benchmark_summary`.
"""
