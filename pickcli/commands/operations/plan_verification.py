"""Verification of the plans of commands: with its time, advice for rejections, and plans from files."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import refuse_arm_mismatch
from pickcli.errors import Failures, InputError, RejectedError

if TYPE_CHECKING:
    from pickcli.motion.plan import Certify, Plan
    from pickcli.scene.scene import Scene


def certified(plan: Plan, scene: Scene, advice: str, path: Path | None = None) -> Plan:
    """Verify a plan.

    Args:
        plan: The plan.
        scene: The scene in which it is to be executed.
        advice: Advice for a rejection.
        path: Its file; None for a new plan.

    Returns:
        The plan with the verifier's certificate.

    Raises:
        RejectedError: With every reason and the advice.
    """
    from pickcli.verification.verify import certify

    began = time.perf_counter()
    try:
        with stage("verification"):
            plan = certify(plan, scene)
    except RejectedError as error:
        what = plan.query if path is None else f"{path}: {plan.query}"
        raise RejectedError(what, error.reasons, advice) from None
    return plan.with_statistics(verification_ms=1e3 * (time.perf_counter() - began))


def timed_certifier(scene: Scene) -> Certify:
    """Return a certifier that notes in each plan how long its verification took.

    Args:
        scene: The scene in which they are to be executed.

    Returns:
        A function that returns a plan with its certificate, or the reasons for its rejection.
    """
    from pickcli.verification.verify import certifier

    judge = certifier(scene)

    def certify(plan: Plan) -> Plan | Failures:
        began = time.perf_counter()
        with stage("verification"):
            judged = judge(plan)
        if isinstance(judged, Failures):
            return judged
        return judged.with_statistics(verification_ms=1e3 * (time.perf_counter() - began))

    return certify


def refuse_tracking(plan: Plan, path: Path) -> None:
    """Refuse a plan for a running conveyor, where set points go out by the clock alone.

    Args:
        plan: The plan.
        path: Its file.

    Raises:
        InputError: Its set points follow the encoder of a conveyor.
    """
    if plan.tracking is not None:
        raise InputError(
            f"{path}: its set points follow the encoder of {plan.tracking.conveyor}, and by the clock alone "
            "they would miss the item; apc execute --stream plays it, by a driver that has that encoder "
            "(docs/how-to/pick-from-a-conveyor.md)"
        )


def trusted(
    plan: Plan, path: Path, believed: Scene, advice: str, scene_path: Path | None, option: str = "--scene"
) -> Plan:
    """Verify a plan from a file even if it has a certificate, which only guards against accidents.

    Args:
        plan: The plan.
        path: Its file.
        believed: The scene that it must be made for.
        advice: Advice for a rejection.
        scene_path: File of that scene; None for the empty cell.
        option: The option that states the scene of a plan.

    Returns:
        The plan with the verifier's certificate.

    Raises:
        RejectedError: The verifier rejects it.
        StaleError: It was made for another scene or cell.
    """
    from pickcli.errors import StaleError
    from pickcli.scene.scene import empty_scene
    from pickcli.scene.scene_file import SCENE_FIGURES, scene_hash

    refuse_arm_mismatch(plan, path, believed.cell)
    here, cell, carried = scene_hash(believed), believed.cell, plan.certificate
    if plan.cell_fingerprint != cell.fingerprint:
        raise StaleError(
            f"{path}: made for the cell {plan.cell_fingerprint[:12]}, {cell.name} is "
            f"{cell.fingerprint[:12]}; plan it again"
        )
    if carried is not None and plan.scene_hash != here:
        this = scene_path or f"{cell.name} with nothing in it"
        fault = (
            f"{path}: made for the scene {plan.scene_hash[:12]}, {this} is {here[:12]} ({SCENE_FIGURES}); "
            "plan it again, or "
        )
        if plan.scene_hash == scene_hash(empty_scene(cell)):
            raise StaleError(f"{fault}name only --cell, as when it was made")
        raise StaleError(f"{fault}name the scene it was made in with {option}")
    plan = certified(plan, believed, advice, path)
    if carried is None:
        click.echo(f"note: {path} has no certificate; it was verified now and accepted", err=True)
    return plan
