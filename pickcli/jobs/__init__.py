"""Resumable jobs, run in this process, on several processes or on a cluster, with the same bytes.

Independent of robotics. Read `job`, `job_result`, and `job_run` with its `journal`; then the `executors`, in
this process and on several, whose tasks run in `worker`; and for the workers of a cluster `dask_executor`
with `dask_client`, `dask_worker` and `dask_results`.
"""
