"""Resumable tasks, done here, on processes or on a cluster, to the same bytes; knows no robot.

Read `job` (what a task is), `job_result`, and `job_run` with its `journal`; then where tasks are done:
`executors`, here and on processes, of which `worker` is the other end; and on the workers of a cluster
`dask_executor` with `dask_client`, `dask_worker` and `dask_results`.
"""
