"""Stream trials: items that come on a conveyor, picked as they pass, or told why not.

`stream_trial` plays what a `stream_trial_request` asks for, with the `stream_arms`, until no `open_item` is
left: `pick_queries` plan by one of the `stream_rules` for the next ones, and `pick_schedule` says which is
taken; each `reserved_motion` keeps out of the others. What the robot knows of items is a
`bounded_perception`, or a `belt_perception` by a `belt_camera`. A `meeting_watch` measures each pick, a
`stream_result` says what became of the items; `stream_record` is what its file says, checked by a
`stream_record_schema`, beside others in a `stream_folder`.

Many trials are a `stream_job`, whose `stream_trials` are summed up by `stream_statistics`; a
`stream_comparison` says what two runs are compared by, and `published_experiments` what the PR2 did in 2013.
"""
