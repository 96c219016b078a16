"""Names of the available sampling-based planners. Importing this file does not import OMPL."""

from __future__ import annotations

from enum import StrEnum


class PlannerName(StrEnum):
    """Planners that are repeatable when limited by iterations.

    RRTConnect is the kernel's; the others are OMPL's, which call Python for every edge: they have the names
    of their classes, with OMPL- before the one that the kernel has as well. PRM is not included (it grows its
    graph in its own thread).
    """

    RRT_CONNECT = "RRTConnect"  # Kuffner and LaValle 2000; Delft's choice
    OMPL_RRT_CONNECT = "OMPL-RRTConnect"  # OMPL's implementation, for comparison with the others
    RRT_STAR = "RRTstar"  # Karaman and Frazzoli 2011; KTH's choice
    INFORMED_RRT_STAR = "InformedRRTstar"  # Gammell et al. 2014
    BIT_STAR = "BITstar"  # Gammell et al. 2015
    AO_RRT_CONNECT = "AORRTC"  # Wilson et al. 2025
    RRT = "RRT"  # LaValle 1998
