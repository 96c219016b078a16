"""Prioritized control: what is to be reached, in levels of which none costs one before it.

`hierarchical_qp` finds the joint velocities of one step, by the kernel.
"""
