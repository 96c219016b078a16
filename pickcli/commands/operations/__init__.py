"""What several commands carry out: builds, verifications, executions and trials, with progress and advice.

`building` runs the jobs of a file. `plan_verification`, `pallet_verification` and `verified_drive` judge what
was planned. `plan_execution` carries plans out, `query_execution` answers the queries of ``apc execute``.
`played_stream`, `played_pallet` and `played_commission` play a trial of their kind, `played_streams` and
`played_commissions` many.
"""
