"""The sampling-based planners on offer. Importing this file does not import OMPL."""

from __future__ import annotations

from enum import StrEnum


class PlannerName(StrEnum):
    """Planners that are repeatable when limited by iterations.

    RRTConnect is the kernel's own; the others are OMPL's, which ask Python about every edge: named by their
    classes there, with OMPL- before the one that the kernel has as well. PRM is not among them (it grows its
    graph in a thread of its own).
    """

    RRT_CONNECT = "RRTConnect"  # Kuffner and LaValle 2000; Delft's choice
    OMPL_RRT_CONNECT = "OMPL-RRTConnect"  # the same by OMPL, to compare the others with
    RRT_STAR = "RRTstar"  # Karaman and Frazzoli 2011; KTH's choice
    INFORMED_RRT_STAR = "InformedRRTstar"  # Gammell et al. 2014
    BIT_STAR = "BITstar"  # Gammell et al. 2015
    AO_RRT_CONNECT = "AORRTC"  # Wilson et al. 2025
    RRT = "RRT"  # LaValle 1998
