"""The hand-made pick, played in the simulated arena of a trial with everything that moves recorded."""

from __future__ import annotations

from pickcli.scene.scene import Scene
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.trial.simulated_cell import SimulatedArena
from support.handmade_plans import pick


def play() -> tuple[MotionRecorder, Scene]:
    """What was recorded, and the scene afterwards."""
    plan, scene = pick()
    recorder = MotionRecorder()
    arena = SimulatedArena(scene, motion_recorder=recorder)
    try:
        arena.execute(plan)
        return recorder, arena.now()
    finally:
        arena.close()
