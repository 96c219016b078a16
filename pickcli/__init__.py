"""apc: proven picking motion for one robot arm or two, at shelves, crates and tables.

Everything in ``__all__`` is stable: docs/reference/python.md lists it. A name is imported at its first use,
so that importing the package takes no time; type checkers read the types of the names from ``__init__.pyi``.
"""

import importlib

__version__ = "0.1.0"

_HOMES = {
    "pickcli.api.planner": ("Planner",),
    "pickcli.cell.cell": ("Cell",),
    "pickcli.cell.cell_file": ("load_cell",),
    "pickcli.cell.item": ("Item",),
    "pickcli.cell.shapes": ("Body", "Shape", "ShapeKind", "box"),
    "pickcli.errors": (
        "ApcError", "DamagedError", "InputError", "NoPlanError", "Reason", "RejectedError", "StaleError",
        "UnknownNameError",
    ),
    "pickcli.geometry": ("pose",),
    "pickcli.motion.event": ("Event",),
    "pickcli.motion.path": ("JointPath",),
    "pickcli.motion.plan": ("Certificate", "Grasp", "Plan"),
    "pickcli.motion.plan_file": ("read_plan", "write_plan"),
    "pickcli.motion.segment": ("Segment", "SegmentKind"),
    "pickcli.motion.trajectory": ("Trajectory",),
    "pickcli.perception.items.perceived_file": ("Perceived", "read_perceived", "write_perceived"),
    "pickcli.scene.cloud": ("Cloud",),
    "pickcli.scene.scene": ("PlacedItem", "PoseNoise", "Scene"),
    "pickcli.scene.scene_file": ("read_scene", "write_scene"),
    "pickcli.simulation.execution": ("Execution",),
    "pickcli.random_scenes.make_scene": ("make_scene",),
    "pickcli.trial.order": ("Order",),
    "pickcli.trial.order_file": ("read_order",),
}  # fmt: skip
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> object:
    """Import a stable name from its module. Raises AttributeError for any other."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(importlib.import_module(_HOME[name]), name)
    return value


def __dir__() -> list[str]:
    """Return the stable names besides the module's own."""
    return sorted({*globals(), *__all__})
