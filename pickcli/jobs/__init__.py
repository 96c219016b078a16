"""Resumable tasks, done here, on processes or on a cluster, to the same bytes; knows no robot.

Read `job` (what a task is), `job_result`, `job_run` with its `journal`, then `executors`; `worker` is the
other end of a process, and `dask_executor` with its client, results and worker runs tasks on a cluster.
"""
