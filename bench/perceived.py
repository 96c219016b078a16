"""How well items are found in pictures, on fresh scenes: how many, how exactly, how often wrongly, how fast.

    python -m bench.perceived [--seeds 1000-1005] [--sensors ensenso carmine] [--json FILE]
    python -m bench.perceived --seeds 10-18 --calibrate
    python -m bench.perceived --seeds 24-39 --sensors ensenso --looks 3 --calibrate
    python -m bench.perceived --seeds 1000 --sensors ensenso --lists
    python -m bench.perceived --seeds 1000-1003 --sensors ensenso --sift all-views [--looks 3 [--calibrate]]

Each seed is an order drawn by the rules of 2016 (46 items in 12 bins), stowed by the package's scene maker,
and printed by a set of prints that no model knows. The camera on the gripper looks once into each bin, as
each of the sensors. An answer is good within 10 mm and 10 degrees of the truth, symmetries of the shape
aside, and wrong over 30 mm; a copy of an item may be taken for the other. Seeds 1 to 3 were used for tuning,
10 to 23 for confidence and bounds by one look, and 24 to 39 for those by several, as ``--calibrate`` prints
them; figures of other seeds are to be reported. CPU time of one thread, without pictures and models.
``--lists`` gives each bin a list with one item too few, which must leave something unexplained, and one with
an item that is not there, which must be refused. With ``--looks 3`` the camera looks from both sides, too,
and answers are what two of the looks agree on; ``--calibrate`` is then for what each two of them say.
``--sift`` looks for the prints of items, too, by each rule that it names (the first, with several looks), and
tells what that brings, on the same pictures: of printed
items that are well seen how many are within 2 mm and 10 degrees with no symmetry set aside, so with the right
face. Models know the set of prints, but as new and in even light; in the pictures labels are damaged, lamp
and amounts of light are drawn, as are exposure and white balance, and there are blur and noise. With
``--looks 3`` the figures are those of answers by several looks, with the set of prints of trials, and
``--calibrate`` is for bounds of poses at which two looks recognised the print.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from itertools import combinations
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np
from scipy.optimize import linprog, minimize

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.place import Place
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.sensors.material import Material
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.sensors.sensor_model import SensorModel
from pickcli.errors import InputError
from pickcli.geometry import Array, rotation_angle
from pickcli.perception.depth_picture import DepthPicture, measure_depth
from pickcli.perception.items.agreement import agreement_features
from pickcli.perception.items.confidence import LEAST_CONFIDENCE, support_features
from pickcli.perception.items.item_observation import FoundBy, ItemObservation, PlaceObservation
from pickcli.perception.items.item_perception import PlaceLook, concluded
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.pose_bound import (
    LEAST_CONFIDENCE_OF_BOUND,
    ROUNDING,
    SURE,
    BoundModel,
    agreed_bound_features,
    bound_features,
)
from pickcli.perception.items.product_model import product_model
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.items.routing import NO_PRINTS, PrintSearch
from pickcli.perception.items.symmetry import error_of
from pickcli.perception.looks import colour_picture
from pickcli.perception.mount_calibration import camera_in_pod
from pickcli.perception.photograph import photograph
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene
from pickcli.perception.surface_view import FloatPicture
from pickcli.perception.textures.print_model import print_model
from pickcli.perception.textures.sift_views import SiftRule
from pickcli.perception.viewpoints import Viewpoint, viewpoints_of
from pickcli.random_scenes.leaning_items import leaning_items
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.seeds import derived_rng, derived_seed
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind
from pickcli.trial.simulated_cameras import PRINTS_OF_TRIALS

SENSORS = ("ensenso", "carmine", "kinect_v2")
GOOD_MM, GOOD_DEG, WRONG_MM, RIGHT_MM = 10.0, 10.0, 30.0, 2.0
VISIBLE = 0.7  # share of an item's pixels that nothing else hides
TEXTURES = 7919  # added to the seed of a scene
REGULARISATION = 0.05
N_FOLDS = 5  # of scenes, for what is calibrated on others
CLASSES, CLASSES_OF_PAIRS = (
    (0.67,),
    (0.5, 0.8),
)  # shares of poses between which classes have factors of their own
MIXING = {"kinect_v2"}  # sensors that mix depths at edges
CONFIDENCE_FEATURE = 2  # index of the one that follows from the confidence
WRONG_FACE_DEG = 30.0
KEPT_BY_PRINT = 0.999  # of poses at which two looks recognised the print
QUANTILE, KEPT = 0.9, 0.995  # of the regression of bounds, and of poses with all errors within them


@dataclass(frozen=True)
class Row:
    """One listed item, and what was said of it. Without a pose, errors are None."""

    sensor: str
    seed: int
    bin: str
    id: str
    n_items: int
    visible: float
    is_answer: bool
    confidence: float
    mm: float | None
    deg: float | None
    surface_mm: float | None
    ms: float
    features: tuple[float, ...] | None
    bound_features: tuple[float, ...] | None
    bound_mm: float | None
    bound_deg: float | None
    bound_surface_mm: float | None
    is_bound_kept: bool
    lean_deg: float = 0.0
    deforms: bool = False
    is_printed: bool = False
    found_by: str = "shape"
    turned_deg: float | None = None  # as deg, but no symmetry is set aside
    is_by_print: bool = False  # in both of two looks that agree
    is_clear: bool = False
    pixels_per_mm: float = 0.0  # at the mouth

    @property
    def is_near(self) -> bool:
        """Whether its pose is within the bounds of a good one, also if it is refused."""
        return self.mm is not None and self.deg is not None and self.mm <= GOOD_MM and self.deg <= GOOD_DEG

    @property
    def is_right(self) -> bool:
        """Whether it is an answer with the right face, within 2 mm."""
        if not self.is_answer or self.mm is None or self.turned_deg is None:
            return False
        return self.mm <= RIGHT_MM and self.turned_deg <= GOOD_DEG

    @property
    def is_good(self) -> bool:
        """Whether it is an answer within the bounds."""
        return self.is_answer and self.is_near

    @property
    def is_wrong(self) -> bool:
        """Whether it is an answer far off, or of another item."""
        return self.is_answer and self.mm is not None and self.mm > WRONG_MM


def fresh_scene(cell: Cell, seed: int, leaning_share: float = 0.0) -> Scene:
    """The bins of an order that nobody has seen, stowed; of what can lean such a share leans."""
    contents = make_order(OrderKind.PICK, 2016, seed).bin_contents
    return make_scene(contents, cell, seed, leaning_share=leaning_share)


def visible_share(rendered: RenderedScene, rgbd: RgbdPicture, item_id: str) -> float:
    """Pixels that show an item, of those that would if there were no other items."""
    camera, T = rgbd.sensor.camera, rgbd.T_world_camera

    def count(solids: RenderedScene) -> int:
        return int(np.isin(solids.seen_by(camera, T).index, solids.indices_of(item_id)).sum())

    alone = RenderedScene(
        tuple(s for s in rendered.solids if s.kind is not OwnerKind.ITEM or s.owner == item_id)
    )
    return count(rendered) / max(count(alone), 1)


@dataclass(frozen=True, eq=False)
class SeenBin:
    """Pictures of a bin from one or several places, each with what is known to be in it.

    rendered: what there is in the first one
    """

    scene: Scene
    place: Place
    pictures: tuple[tuple[RgbdPicture, RenderedScene], ...]
    rendered: RenderedScene
    is_deformed: bool = False

    @property
    def rgbd(self) -> RgbdPicture:
        """The first picture."""
        return self.pictures[0][0]

    @property
    def items(self) -> tuple[PlacedItem, ...]:
        """What is in it."""
        return self.scene.in_location(self.place.name)

    def looks(self, listed: Sequence[ListedItem], prints: PrintSearch = NO_PRINTS) -> list[PlaceLook]:
        """What is found of a list in each picture."""
        T, place = self.scene.T_world_place(self.place), self.place
        return [PlaceLook.of(rgbd, place, T, listed, known, prints) for rgbd, known in self.pictures]

    def perceived(self, listed: Sequence[ListedItem]) -> PlaceObservation:
        """What is found of a list."""
        return concluded(self.looks(listed))


@cache
def from_where(cell: Cell, n_looks: int) -> dict[Place, tuple[Viewpoint, ...]]:
    """From where each bin is looked into, so many at most."""
    return {place: viewpoints_of(place, cell)[:n_looks] for place in cell.pod.bins.values()}


def seen_bins(
    scene: Scene, sensor: SensorModel, n_looks: int = 1, is_deformed: bool = False,
    print_set: int | None = None,
) -> Iterator[SeenBin]:  # fmt: skip
    """All bins, seen from so many places each; cloth and bags perhaps rumpled.

    With a set of prints that models know, labels are damaged, and pictures are as cameras take them.
    """
    deformed_seed = scene.seed if is_deformed else None
    empty = replace(scene, items=())
    for place, viewpoints in from_where(scene.cell, n_looks).items():
        pictures = []
        for k, viewpoint in enumerate(viewpoints):
            at, T = viewpoint.at, viewpoint.T_world_camera
            rendered = RenderedScene.of(scene, at.q, at.tool_state, deformed_seed)
            seed = derived_seed("look", scene.seed, at.name) if k else scene.seed
            depth = measure_depth(rendered, sensor, T, seed).depth
            if print_set is None:
                colour = colour_picture(rendered, sensor.camera, T, TEXTURES + scene.seed)
            else:
                taken = derived_seed("taken", scene.seed, place.name, k)
                colour = photograph(rendered, sensor.camera, T, print_set, scene.seed, taken)
            known = RenderedScene.of(empty, at.q, at.tool_state)
            if print_set is not None and n_looks > 1:
                T = located(scene, sensor, T, depth)
            pictures.append((RgbdPicture(sensor, T, depth, colour), known))
        at = viewpoints[0].at
        rendered = RenderedScene.of(scene, at.q, at.tool_state, deformed_seed)
        yield SeenBin(scene, place, tuple(pictures), rendered, is_deformed)


def located(scene: Scene, sensor: SensorModel, T_world_camera: Array, depth: FloatPicture) -> Array:
    """Pose (4, 4) of a camera relative to the pod in its picture, as in trials; as stated if that fails."""
    picture = DepthPicture(sensor.camera, T_world_camera, depth)
    assert sensor.depth is not None
    try:
        fit = camera_in_pod(picture, scene.cell, sensor.depth, scene.T_world_pod)
    except InputError:
        return T_world_camera
    return np.asarray(scene.T_world_pod @ fit.T_pod_camera)


def rows_of_scene(
    scene: Scene, sensor: SensorModel, n_looks: int = 1, in_pairs: bool = False, is_deformed: bool = False,
    prints: PrintSearch = NO_PRINTS,
) -> Iterator[Row]:  # fmt: skip
    """All items of all bins, each seen from so many places; or what each two of these looks say of them."""
    print_set = None if prints is NO_PRINTS else prints.texture_seed
    for seen in seen_bins(scene, sensor, n_looks, is_deformed, print_set):
        listed = [ListedItem.of(each.id, each.item, is_deformed) for each in seen.items]
        for one in listed:
            product_model(one.seen_as)
        start = thread_time()
        leaning = leaning_items(scene)
        looks = seen.looks(listed, prints)
        observed = [concluded(each) for each in (combinations(looks, 2) if in_pairs else [looks])]
        ms = 1e3 * (thread_time() - start) / max(len(seen.items), 1)
        visible = [visible_share(seen.rendered, seen.rgbd, placed.id) for placed in seen.items]
        for each in observed:
            for answer, share in zip(each.items, visible, strict=True):
                row = _row(sensor, (scene.seed, seen.place.name, ms), seen.items, answer, share)
                lean = float(np.degrees(leaning.get(answer.id, 0.0)))
                yield replace(row, lean_deg=lean, deforms=answer.item.deformation > 0.0)


def rows_by_rules(
    scene: Scene, sensor: SensorModel, rules: Sequence[SiftRule], print_set: int
) -> Iterator[dict[SiftRule, Row]]:
    """All items of all bins in one look each, by each rule for which items prints are looked for."""
    for seen in seen_bins(scene, sensor, print_set=print_set):
        listed = [ListedItem.of(each.id, each.item, False) for each in seen.items]
        for one in listed:
            product_model(one.seen_as)
            if one.item.is_printed:
                print_model(one.item, print_set)
        found = {}
        for rule in rules:
            start = thread_time()
            (look,) = seen.looks(listed, PrintSearch(rule, print_set))
            observed = concluded([look])
            found[rule] = (observed, 1e3 * (thread_time() - start) / max(len(listed), 1))
        for i, placed in enumerate(seen.items):
            share = visible_share(seen.rendered, seen.rgbd, placed.id)
            yield {
                rule: replace(
                    _row(sensor, (scene.seed, seen.place.name, ms), seen.items, observed.items[i], share),
                    pixels_per_mm=look.pixels_per_mm,
                )
                for rule, (observed, ms) in found.items()
            }


def print_summary(rows: Sequence[Row]) -> dict[str, float]:
    """What is known of printed items that are well seen, and how often what is said by prints is wrong."""
    well_seen = [r for r in rows if r.is_printed and r.visible >= VISIBLE]
    by_print = [r for r in rows if r.is_answer and r.found_by == FoundBy.PRINT]
    ms = np.array([r.ms for r in rows])
    return {
        "well_seen_printed": len(well_seen),
        "right": sum(r.is_right for r in well_seen) / max(len(well_seen), 1),
        "good": sum(r.is_good for r in well_seen) / max(len(well_seen), 1),
        "by_print": len(by_print),
        "by_print_wrong": sum(r.is_wrong for r in by_print) / max(len(by_print), 1),
        "by_print_wrong_face": sum((r.turned_deg or 0.0) > WRONG_FACE_DEG for r in by_print)
        / max(len(by_print), 1),
        "good_of_all": sum(r.is_good for r in rows) / len(rows),
        "answers": sum(r.is_answer for r in rows),
        "wrong_of_answers": sum(r.is_wrong for r in rows) / max(sum(r.is_answer for r in rows), 1),
        "ms_median": float(np.median(ms)),
        "ms_p95": float(np.percentile(ms, 95)),
    }


def report_prints(rows: Sequence[dict[SiftRule, Row]], rules: Sequence[SiftRule]) -> dict[str, Any]:
    """Print what the search for prints brings, by sensor and rule."""
    found: dict[str, Any] = {}
    for name in dict.fromkeys(each[rules[0]].sensor for each in rows):
        for rule in rules:
            own = [each[rule] for each in rows if each[rule].sensor == name]
            s = print_summary(own)
            found[f"{name} {rule}"] = s
            print(f"{name} ({own[0].pixels_per_mm:.2f} px per mm) --sift {rule}: ", end="")
            print(f"of {s['well_seen_printed']} printed items well seen", end=" ")
            print(f"right face and {RIGHT_MM:g} mm {s['right']:.1%}, good {s['good']:.1%}")
            print(f"  by prints {s['by_print']} answers, wrong {s['by_print_wrong']:.1%}, ", end="")
            print(f"another face {s['by_print_wrong_face']:.1%}")
            print(f"  of all items good {s['good_of_all']:.1%}; of {s['answers']} answers wrong", end=" ")
            print(f"{s['wrong_of_answers']:.1%}; ms an item {s['ms_median']:.0f}, p95 {s['ms_p95']:.0f}")
    return found


def wrong_lists(scene: Scene, sensor: SensorModel) -> Iterator[tuple[str, bool]]:
    """By kind of list whether something is said of it: that there is more, or that an item is not there."""
    rng = derived_rng("lists", scene.seed)
    products = sorted(
        {item for (_, year), item in scene.cell.items.items() if year == 2016}, key=lambda i: i.name
    )
    for seen in seen_bins(scene, sensor):
        listed = [ListedItem.of(each.id, each.item, seen.is_deformed) for each in seen.items]
        whole = seen.perceived(listed)
        if not whole.refused:
            yield "right list, something left", bool(whole.unexplained)
        left_out = listed[int(rng.integers(len(listed)))]
        if visible_share(seen.rendered, seen.rgbd, left_out.id) >= VISIBLE:
            fewer = seen.perceived([each for each in listed if each is not left_out])
            yield "well seen item not listed, something left", bool(fewer.unexplained)
        absent = [item for item in products if item not in {each.item for each in listed}]
        extra = absent[int(rng.integers(len(absent)))]
        more = seen.perceived([*listed, ListedItem(extra.name, extra)])
        yield "item listed that is not there, refused", not more.items[-1].is_answer


def _row(
    sensor: SensorModel, of: tuple[int, str, float], items: Sequence[PlacedItem], answer: ItemObservation,
    visible: float,
) -> Row:  # fmt: skip
    assert sensor.depth is not None
    error = features = of_bound = turned = None
    if answer.T_world_item is not None:
        shape, T = answer.item.shape, answer.T_world_item
        copies = [each.T_world_item for each in items if each.item == answer.item]
        error = min((error_of(shape, T, T_true) for T_true in copies), key=lambda each: each.position)
        true = min(copies, key=lambda each: float(np.linalg.norm(each[:3, 3] - T[:3, 3])))
        turned = float(np.degrees(rotation_angle(T[:3, :3].T @ true[:3, :3])))
    if answer.support is not None:
        lost = sensor.depth.no_return.get(answer.item.material, 0.0)
        of_confidence = support_features(answer.support, lost, len(items))
        bounds_by = bound_features(answer.support, lost, answer.confidence)
        if answer.agreement is not None:
            of_confidence = agreement_features(answer.support, lost, len(items), answer.agreement)
            bounds_by = agreed_bound_features(answer.support, lost, answer.confidence, answer.agreement)
        features, of_bound = tuple(of_confidence.tolist()), tuple(bounds_by.tolist())
    is_kept = error is not None and answer.bound is not None and answer.bound.holds(error)
    seed, name, ms = of
    return Row(
        sensor.name, seed, name, answer.id, len(items), visible, answer.is_answer, answer.confidence,
        *_in_mm_and_degrees(error), ms, features, of_bound, *_in_mm_and_degrees(answer.bound), is_kept,
        is_printed=answer.item.is_printed, found_by=answer.found_by.value, turned_deg=turned,
        is_by_print=answer.agreement is not None and answer.agreement.is_by_print,
        is_clear=answer.item.material is Material.CLEAR,
    )  # fmt: skip


def _in_mm_and_degrees(error: PoseNoise | None) -> tuple[float | None, float | None, float | None]:
    """Of the position, the angle and the surface."""
    if error is None or error.displacement is None:
        return None, None, None
    return 1e3 * error.position, float(np.degrees(error.angle)), 1e3 * error.displacement


def summary(rows: Sequence[Row]) -> dict[str, float]:
    """The figures of one sensor."""
    answers, good = [r for r in rows if r.is_answer], [r for r in rows if r.is_good]
    well_seen = [r for r in rows if r.visible >= VISIBLE]
    bounded = [r for r in answers if r.bound_mm is not None]
    mm, deg = np.array([r.mm for r in good]), np.array([r.deg for r in good])
    ms = np.array([r.ms for r in rows])
    return {
        "items": len(rows),
        "answered": len(answers) / len(rows),
        "good": len(good) / len(rows),
        "well_seen": len(well_seen) / len(rows),
        "good_of_well_seen": sum(r.is_good for r in well_seen) / max(len(well_seen), 1),
        "wrong_of_answers": sum(r.is_wrong for r in answers) / max(len(answers), 1),
        "bounded_of_answers": len(bounded) / max(len(answers), 1),
        "bound_kept": sum(r.is_bound_kept for r in bounded) / max(len(bounded), 1),
        "bound_mm_median": float(np.median([r.bound_mm for r in bounded])),
        "bound_deg_median": float(np.median([r.bound_deg for r in bounded])),
        "bound_surface_mm_median": float(np.median([r.bound_surface_mm for r in bounded])),
        "mean_confidence": float(np.mean([r.confidence for r in answers])),
        "good_of_answers": len(good) / max(len(answers), 1),
        "mm_median": float(np.median(mm)),
        "mm_p95": float(np.percentile(mm, 95)),
        "deg_median": float(np.median(deg)),
        "deg_p95": float(np.percentile(deg, 95)),
        "ms_median": float(np.median(ms)),
        "ms_p95": float(np.percentile(ms, 95)),
    }


def reliability(rows: Sequence[Row]) -> list[tuple[str, int, float, float]]:
    """By confidence: how many poses, how confident in the mean, and how many of them near."""
    found = [r for r in rows if r.mm is not None]
    table = []
    for low, high in ((0.0, 0.1), (0.1, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 0.99), (0.99, 1.0)):
        of = [r for r in found if low <= r.confidence < high]
        if of:
            confidence = float(np.mean([r.confidence for r in of]))
            table.append((f"{low:g} to {high:g}", len(of), confidence, sum(r.is_near for r in of) / len(of)))
    return table


def calibrated(rows: Sequence[Row]) -> Array:
    """Weights of the logistic model of the confidence, by all poses found, refused or not."""
    found = [r for r in rows if r.features is not None]
    X, y = np.array([r.features for r in found]), np.array([r.is_near for r in found])

    def cost(weights: Array) -> float:
        z = X @ weights
        likelihood = np.logaddexp(0.0, -z)[y].sum() + np.logaddexp(0.0, z)[~y].sum()
        return float(likelihood + REGULARISATION * (weights[1:] ** 2).sum())

    return np.asarray(minimize(cost, np.zeros(X.shape[1])).x)


def quantile_weights(features: Array, wanted: Array) -> Array:
    """Weights of a quantile regression, as a linear program."""
    n, n_features = features.shape
    costs = np.repeat([0.0, QUANTILE, 1.0 - QUANTILE], [2 * n_features, n, n])  # of weights, above, below
    rows = np.hstack([features, -features, np.eye(n), -np.eye(n)])
    found = linprog(costs, A_eq=rows, b_eq=wanted, bounds=(0.0, None), method="highs").x
    return np.asarray(found[:n_features] - found[n_features : 2 * n_features])


def calibrated_bounds(
    features: Array,
    errors: Array,
    scenes: Sequence[int],
    between: Sequence[float] = CLASSES,
    kept: float = KEPT,
) -> BoundModel:
    """Bounds of errors (N, 3) by features (N, F), with factors that keep nearly all of each class.

    The factors are what keeps them in scenes that the weights were not fitted to.
    """
    wanted, usual = np.log(errors + ROUNDING), np.zeros_like(errors)
    folds = np.array(scenes) % N_FOLDS
    for fold in np.unique(folds):
        is_here = folds == fold
        for k, error in enumerate(wanted.T):
            usual[is_here, k] = features[is_here] @ quantile_weights(features[~is_here], error[~is_here])
    excess, classes = (wanted - usual).max(axis=1), np.quantile(usual[:, 2], between)
    own = np.searchsorted(classes, usual[:, 2])
    return BoundModel(
        np.array([quantile_weights(features, error) for error in wanted.T]),
        classes,
        np.array([np.quantile(excess[own == k], kept, method="higher") for k in range(len(classes) + 1)]),
    )


def confidences_of_others(rows: Sequence[Row]) -> Array:
    """(N,) confidences by weights that were fitted to other scenes."""
    folds, X = np.array([r.seed for r in rows]) % N_FOLDS, np.array([r.features for r in rows])
    found = np.zeros(len(rows))
    for fold in np.unique(folds):
        others = [r for r, own in zip(rows, folds, strict=True) if own != fold]
        found[folds == fold] = 1.0 / (1.0 + np.exp(-X[folds == fold] @ calibrated(others)))
    return found


def print_calibration(rows: Sequence[Row], between: Sequence[float]) -> None:
    """Print the weights of confidence and bounds."""
    found = [r for r in rows if r.features is not None]
    print("confidence", np.array2string(calibrated(found), precision=3, separator=", "))
    confidences = confidences_of_others(found)
    answers = [(r, c) for r, c in zip(found, confidences, strict=True) if c >= LEAST_CONFIDENCE_OF_BOUND]
    for name, is_mixed in (("sharp edges", False), ("mixed edges", True)):
        own = [(r, c) for r, c in answers if (r.sensor in MIXING) is is_mixed]
        if not own:
            continue
        features = np.array([with_confidence(r, c) for r, c in own])
        errors = np.array([[r.mm, r.deg, r.surface_mm] for r, _ in own], dtype=np.float64)
        model = calibrated_bounds(features, errors, [r.seed for r, _ in own], between)
        for part, values in asdict(model).items():
            print(name, part, np.array2string(values, precision=3, separator=", "))


def print_calibration_of_prints(rows: Sequence[Row]) -> None:
    """Print how often poses by the print in two looks are right, and the weights of their bounds."""
    found = [r for r in rows if r.is_by_print]
    near = [r for r in found if r.is_near]
    print(f"by print in two looks {len(found)}, of which near {len(near)}")
    errors = np.array([[r.mm, r.deg, r.surface_mm] for r in near], dtype=np.float64)
    features = np.array([r.bound_features for r in near])
    model = calibrated_bounds(features, errors, [r.seed for r in near], CLASSES, KEPT_BY_PRINT)
    for part, values in asdict(model).items():
        print(part, np.array2string(values, precision=3, separator=", "))


def with_confidence(row: Row, confidence: float) -> Array:
    """What the bounds of a row follow from, with another confidence."""
    assert row.bound_features is not None
    features = np.array(row.bound_features)
    features[CONFIDENCE_FEATURE] += np.log((1.0 - confidence + SURE) / (1.0 - row.confidence + SURE))
    return features


def coarser(sensor: SensorModel, times: float) -> SensorModel:
    """A sensor with pixels so many times as wide, of the same field of view."""
    if times == 1.0:
        return sensor
    c = sensor.camera
    cx, cy = (c.cx + 0.5) / times - 0.5, (c.cy + 0.5) / times - 0.5
    camera = PinholeCamera(c.fx / times, c.fy / times, cx, cy, int(c.width / times), int(c.height / times))
    return replace(sensor, name=f"{sensor.name} coarser {times:g} times", camera=camera)


def numbers_in(text: str) -> list[int]:
    """Of "1000-1005" or "1,2,3"."""
    if "-" in text:
        first, last = map(int, text.split("-"))
        return list(range(first, last + 1))
    return [int(part) for part in text.split(",")]


def report_lists(found: Sequence[tuple[str, bool]]) -> None:
    """Print how often something is said of lists, by their kind."""
    for kind in sorted({kind for kind, _ in found}):
        said = [is_said for of, is_said in found if of == kind]
        print(f"{kind}: {sum(said)} of {len(said)}")


def report(rows: Sequence[Row]) -> dict[str, Any]:
    """Print the figures of each sensor, and how far confidences can be trusted."""
    found: dict[str, Any] = {}
    for name in dict.fromkeys(r.sensor for r in rows):
        found[name] = summary([r for r in rows if r.sensor == name])
        s = found[name]
        print(f"{name}: {s['items']} items, of which {s['well_seen']:.0%} are well seen")
        print(f"  answered {s['answered']:.1%}, with a confidence from {LEAST_CONFIDENCE:g} on")
        print(f"  good {s['good']:.1%}, of well seen {s['good_of_well_seen']:.1%}")
        print(f"  wrong of answers {s['wrong_of_answers']:.1%}")
        print(f"  good ones off {s['mm_median']:.2f} mm {s['deg_median']:.2f} deg, ", end="")
        print(f"p95 {s['mm_p95']:.1f} mm {s['deg_p95']:.1f} deg")
        print(f"  bounds of {s['bounded_of_answers']:.1%} of answers, kept {s['bound_kept']:.1%}, ", end="")
        print(f"median {s['bound_mm_median']:.1f} mm {s['bound_deg_median']:.1f} deg, ", end="")
        print(f"surface {s['bound_surface_mm_median']:.1f} mm")
        print(f"  ms an item {s['ms_median']:.0f}, p95 {s['ms_p95']:.0f}")
    print("confidence: poses, mean confidence, share that is near")
    for label, n, confidence, share in reliability(rows):
        print(f"  {label:12s} {n:5d}  {confidence:.3f}  {share:.3f}")
    return found


def main() -> None:
    """Look, and print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", default="1000-1005", help="of scenes, e.g. 1000-1005 or 1,2,3")
    parser.add_argument("--sensors", nargs="+", default=list(SENSORS), help="files under data/sensors")
    parser.add_argument("--looks", type=int, default=1, choices=(1, 2, 3), help="into each bin")
    parser.add_argument("--leaning", type=float, default=0.0, help="share of what can lean that does")
    parser.add_argument("--deformed", action="store_true", help="cloth, bags and plush look rumpled")
    parser.add_argument("--calibrate", action="store_true", help="also print weights of the confidence")
    parser.add_argument("--lists", action="store_true", help="lists with an item too few, and one too many")
    parser.add_argument(
        "--sift", nargs="+", type=SiftRule, choices=list(SiftRule), help="look for prints, too, by each rule"
    )
    parser.add_argument(
        "--coarser", nargs="+", type=float, default=[1.0], help="also with pixels so many times as wide"
    )
    parser.add_argument("--json", type=Path, help="also write figures and all rows there")
    arguments = parser.parse_args()
    cell = load_cell("apc2016_delft")
    named = [read_sensor(sensor_file(name)) for name in arguments.sensors]
    sensors = [coarser(sensor, times) for sensor in named for times in arguments.coarser]
    if arguments.lists:
        scenes = [fresh_scene(cell, seed, arguments.leaning) for seed in numbers_in(arguments.seeds)]
        report_lists([said for scene in scenes for sensor in sensors for said in wrong_lists(scene, sensor)])
        return
    if arguments.sift is not None:
        seeds = numbers_in(arguments.seeds)
        print_set = PRINTS_OF_TRIALS if arguments.looks > 1 else TEXTURES + seeds[0]
        prints = PrintSearch(arguments.sift[0], print_set)
        scenes = [fresh_scene(cell, seed, arguments.leaning) for seed in seeds]
        if arguments.looks > 1:
            seen = [
                row
                for scene in scenes
                for sensor in sensors
                for row in rows_of_scene(scene, sensor, arguments.looks, arguments.calibrate, prints=prints)
            ]
            if arguments.calibrate:
                print_calibration_of_prints(seen)
            else:
                report(seen)
                print("only clear ones:")
                report([row for row in seen if row.is_clear])
            return
        rules = list(dict.fromkeys((SiftRule.NONE, *arguments.sift)))
        by_rules = [
            row
            for scene in scenes
            for sensor in sensors
            for row in rows_by_rules(scene, sensor, rules, print_set)
        ]
        found = report_prints(by_rules, rules)
        if arguments.json is not None:
            every = [{rule: asdict(row) for rule, row in each.items()} for each in by_rules]
            arguments.json.write_text(json.dumps({"summary": found, "rows": every}, indent=1) + "\n")
        return
    rows: list[Row] = []
    for seed in numbers_in(arguments.seeds):
        scene = fresh_scene(cell, seed, arguments.leaning)
        for sensor in sensors:
            in_pairs = arguments.calibrate and arguments.looks > 1
            rows += rows_of_scene(scene, sensor, arguments.looks, in_pairs, arguments.deformed)
    found = report(rows)
    if arguments.leaning:
        print("only those that lean:")
        report([row for row in rows if row.lean_deg])
    if arguments.deformed:
        print("only those that deform:")
        report([row for row in rows if row.deforms])
    if arguments.calibrate:
        print_calibration(rows, CLASSES_OF_PAIRS if arguments.looks > 1 else CLASSES)
    if arguments.json is not None:
        arguments.json.write_text(
            json.dumps({"summary": found, "rows": [asdict(r) for r in rows]}, indent=1) + "\n"
        )


if __name__ == "__main__":
    main()
