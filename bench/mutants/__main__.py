"""``python -m bench.mutants``: the share of small faults in the code that its own tests find.

A sample of the faults of each package, drawn from a seed, is tried in random order, one after the other,
until the time is over that --minutes gives to a package. Of a fault that no test finds the line is reported:
a test is missing there, or the line, or the fault changes nothing.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

from bench.mutants.mutate import Mutant, mutants
from bench.mutants.reach import Reach, measured
from bench.mutants.trial import ROOT, survives
from bench.mutants.warm import WarmTests
from pickcli.seeds import derived_rng

GOAL = 0.9  # of the mutants of each package
PATIENCE, GRACE = 4.0, 20.0  # times the time of a test without a fault, and s: what takes longer never ends


@dataclass(frozen=True)
class Package:
    """Modules that the same tests answer for."""

    name: str
    modules: tuple[str, ...]
    tests: tuple[str, ...]


PACKAGES = (
    Package(
        "score",
        ("trial/score",),
        ("tests/trial/test_score.py",),
    ),
    Package(
        "orders",
        ("files/json_reader", "trial/order_file", "trial/order"),
        ("tests/files/test_json_reader.py", "tests/trial/test_order_file.py", "tests/trial/test_moves.py"),
    ),
    Package(
        "cell files",
        ("files/yaml_reader", "files/xml_mistakes", "cell/robots/urdf", "cell/robots/urdf_link",
         "cell/robots/urdf_joint", "cell/robots/urdf_origin", "cell/checks/consistency",
         "cell/checks/references", "cell/checks/robot_consistency", "cell/checks/tool_consistency",
         "cell/checks/station_consistency", "files/schema", "files/bounded_reading", "files/atomic_write"),
        (
            "tests/files/test_yaml_reader.py", "tests/cell/test_urdf_mistakes.py",
            "tests/cell/test_cell_bounds.py", "tests/cell/test_cell_mistakes.py",
            "tests/files/test_atomic_write.py", "tests/files/test_bounded_reading.py",
            "tests/cell/test_default_cell.py", "tests/cell/test_parts_agree.py",
            "tests/cell/test_tool_states.py", "tests/cell/test_other_robots.py",
            "tests/cell/test_gripper.py", "tests/cell/test_own_places.py",
            "tests/cell/test_shelf_and_tote.py", "tests/cell/test_arms.py", "tests/files/test_schema.py",
        ),
    ),
    Package(
        "scene files",
        ("scene/scene_checks", "scene/scene_file", "scene/solid_overlap"),
        ("tests/scene/test_scene_file.py", "tests/scene/test_scene_checks.py",
         "tests/scene/test_solid_overlap.py", "tests/scene/test_cloud.py",
         "tests/scene/test_overlap_bounds.py", "tests/scene/test_places_in_scenes.py"),
    ),
    Package(
        "plan files",
        ("motion/plan_schema", "motion/plan_file"),
        ("tests/motion/test_plan_file.py",),
    ),
    Package(
        "store",
        ("storage/safe_open", "storage/table_reader", "storage/integrity_scan", "storage/header_backup",
         "storage/table_writer", "roadmap/validate"),
        ("tests/storage/test_tables.py", "tests/roadmap/test_validate.py", "tests/roadmap/test_store.py",
         "tests/storage/test_integrity_scan.py"),
    ),
    Package(
        "verifier",
        ("verification/joint_limit_check", "verification/structure_check", "verification/event_check",
         "verification/vacuum_events",
         "verification/release_check", "verification/contact_exemptions", "verification/quintic",
         "verification/straightness_check", "verification/contact_check", "verification/grasp_check",
         "verification/clearance_check", "verification/broad_phase", "verification/solid_arrays",
         "verification/pair_distance", "verification/tipping_check", "verification/load_check",
         "verification/separation", "verification/recovery_check", "verification/exemptions",
         "verification/support_check", "verification/tool_speed", "verification/static_solids",
         "verification/held_pose", "verification/state_sampling", "verification/equilibrium",
         "verification/body_boxes", "verification/contact_pile", "verification/pile_statics",
         "verification/landing_statics", "verification/pinch_check", "verification/finger_events",
         "verification/finger_kinematics", "verification/hold_choice", "verification/cloud_points",
         "verification/moving_parts", "verification/forward_kinematics", "verification/fcl_solids",
         "verification/ray_casting",
         "verification/verify"),
        ("tests/verification/test_figures.py", "tests/verification/test_events.py",
         "tests/verification/test_quintic.py",
         "tests/verification/test_load_check.py", "tests/verification/test_planned_touch.py",
         "tests/verification/test_verify.py", "tests/verification/test_clearance_check.py",
         "tests/verification/test_broad_phase.py", "tests/verification/test_recovery_levels.py",
         "tests/verification/test_held_from_start.py", "tests/verification/test_tipping_check.py",
         "tests/verification/test_fcl_solids.py", "tests/verification/test_event_bounds.py",
         "tests/verification/test_tipping_geometry.py", "tests/verification/test_separation.py",
         "tests/verification/test_load_model.py", "tests/verification/test_recovery_bounds.py",
         "tests/verification/test_fingers.py", "tests/verification/test_clearance_bounds.py",
         "tests/verification/test_at_the_limit.py", "tests/verification/test_straightness.py",
         "tests/verification/test_contact_depth.py", "tests/verification/test_release_check.py",
         "tests/verification/test_exemptions.py", "tests/verification/test_static_solids.py",
         "tests/verification/test_state_sampling.py", "tests/verification/test_equilibrium.py",
         "tests/verification/test_pile_statics.py", "tests/verification/test_own_kinematics.py",
         "tests/verification/test_moving_parts.py", "tests/verification/test_ray_casting.py",
         "tests/verification/test_pinch_check.py", "tests/verification/test_finger_events.py",
         "tests/verification/test_cloud_points.py", "tests/verification/test_documented_figures.py"),
    ),
    Package(
        "contact rules",
        ("collision/allowed_contacts", "statics/supports", "statics/balance", "statics/contact_graph",
         "statics/solid_contact", "scene/touching"),
        ("tests/collision/test_allowed_contacts.py", "tests/statics/test_supports.py",
         "tests/statics/test_balance.py", "tests/statics/test_slumping.py", "tests/scene/test_touching.py",
         "tests/statics/test_solid_contact.py"),
    ),
    Package(
        "load rules",
        ("cell/tools/cup_limits", "grasping/holding"),
        ("tests/cell/test_cup_limits.py", "tests/grasping/test_holding.py"),
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Tried:
    """What came of a package's mutants: how many its tests found, and those that they did not."""

    n_found: int = 0
    left: tuple[tuple[str, Mutant], ...] = ()

    @property
    def n(self) -> int:
        """How many were tried."""
        return self.n_found + len(self.left)


def main() -> None:
    """Try the mutants and print what was found, by package and seed and of all."""
    options, lines, every = _options(), list[str](), list[Tried]()
    for package in PACKAGES:
        if options.only is not None and options.only not in package.name:
            continue
        tests = [test for test in package.tests if (ROOT / test).exists()]
        reach, warm = _reach(package, tests), WarmTests(tests)
        for seed in options.seed:
            chosen = sample(package, options.mutants, seed)
            tried = _tried(package, chosen, 60.0 * options.minutes, reach, warm)
            untried = f", {len(chosen) - tried.n} not tried in time" if tried.n < len(chosen) else ""
            lines.append(f"{_line(package.name, tried)} of seed {seed}{untried}")
            every.append(tried)
            print(lines[-1], flush=True)
        warm.close()
    left = tuple(each for tried in every for each in tried.left)
    print("\nFound by its own tests", *lines, sep="\n")
    print(_line("all", Tried(sum(tried.n_found for tried in every), left)))
    sys.exit(0 if all(tried.n_found >= GOAL * tried.n for tried in every) else 1)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m bench.mutants", description=__doc__)
    parser.add_argument("--mutants", type=int, default=30, help="of each package and seed")
    parser.add_argument("--seed", type=int, nargs="+", default=[1])
    parser.add_argument("--only", help="packages whose name holds this text")
    parser.add_argument(
        "--minutes",
        type=float,
        default=float("inf"),
        help="of each package and seed, at most, once its tests ran",
    )
    return parser.parse_args()


def _tried(
    package: Package, chosen: list[tuple[str, Mutant]], seconds: float, reach: Reach, warm: WarmTests
) -> Tried:
    """Try mutants in their order until the time is over; tells each that is left, and how it stands."""
    began, tried = time.monotonic(), Tried()
    for module, mutant in chosen:
        if time.monotonic() - began > seconds:
            break
        if _survives(module, mutant, reach, warm):
            tried = replace(tried, left=(*tried.left, (module, mutant)))
            print(f"  survived: pickcli/{module}.py:{mutant}", flush=True)
        else:
            tried = replace(tried, n_found=tried.n_found + 1)
        print(f"  {_line(package.name, tried)}", file=sys.stderr, flush=True)
    return tried


def _survives(module: str, mutant: Mutant, reach: Reach, warm: WarmTests) -> bool:
    """Whether no test notices a mutant; where what runs before the tests ran it, in a process of its own."""
    path, source = _path(module), mutant.source()
    ran, everyone = reach.of(module, mutant.line, mutant.last)
    most = {name: PATIENCE * reach.seconds[name] + GRACE for name in ran}
    return warm.survives(path, source, most) and (
        not everyone or survives(path, source, everyone, PATIENCE * reach.cpu_s + GRACE)
    )


def sample(package: Package, n: int, seed: int) -> list[tuple[str, Mutant]]:
    """Mutants of a package in random order, the same for the same seed and code: fewer are the first ones."""
    everything = [(m, mutant) for m in package.modules for mutant in mutants(_path(m).read_text())]
    rng = derived_rng("mutants", seed, package.name)
    return [everything[i] for i in rng.permutation(len(everything))[:n].tolist()]


def _reach(package: Package, tests: list[str]) -> Reach:
    """What the tests reach as things are. Ends the program where they fail: then they find nothing."""
    reach = measured(package.modules, tests)
    if reach is None:
        sys.exit(f"{package.name}: its tests fail without any fault; mend that first")
    return reach


def _path(module: str) -> Path:
    return ROOT / "pickcli" / f"{module}.py"


def _line(name: str, tried: Tried) -> str:
    share = 100.0 * tried.n_found / max(tried.n, 1)
    return f"{name:<18} {tried.n_found:>4} of {tried.n:>4} found, {share:5.1f} %"


if __name__ == "__main__":
    import fcl  # noqa: F401  what the tests need, loaded once instead of once per mutant
    import h5py  # noqa: F401
    import hypothesis  # noqa: F401
    import numpy.testing  # noqa: F401
    import pydantic  # noqa: F401
    import scipy.spatial  # noqa: F401
    import yaml  # noqa: F401

    main()
