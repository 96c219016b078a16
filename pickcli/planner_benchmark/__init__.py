"""Planners compared on the same queries: entries, runs, and a summary.

Read `planner_benchmark`, which runs `benchmark_entries` and hands what they find to `benchmark_summary`.
"""
