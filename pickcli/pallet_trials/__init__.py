"""Pallet trials: cartons that the arm stacks on a pallet, as planned beforehand.

In a `pallet_station`, the cell and what it can take, `pallet_trial` plays a planned stack, with a
`pallet_result`; `pallet_record` is what its file says, beside others in a `pallet_folder`.
"""
