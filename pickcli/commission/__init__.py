"""Commissions: a truck takes a pallet, its arm fills it from a load, and the truck delivers it.

The APPLE system's chain (Krug et al. 2016, Fig. 7). A `commission`, read by `commission_file`, in a cell is a
`commission_station`. `commission_trial` lets a tree play it with the `commission_truck` and the
`commission_arm`, or the `belts_arm`, which has a hand with belts; a `commission_result` says what came of it,
and a `commission_record`, with its `commission_record_schema`, what its file says, beside others in a
`commission_folder`. `booth_people` walk past its drives, which a `people_watch` oversees.

Many trials are a `commission_job`, whose `commission_trials` are summed up by `commission_statistics`; a
`commission_comparison` says what two runs are compared by.
"""
