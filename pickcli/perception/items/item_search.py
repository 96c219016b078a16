"""The search for all listed items of one place, in one view of it.

After PR2's refined localisation (the conveyor paper, III-D), and render and compare. In each round starts are
put where the picture is not explained, fitted to the points near them by Powell's dogleg, and moved while
they explain the picture better; then the options of all items are decided together. Items that explain all
that they should show are settled; the others are searched again in the next round, among all that is placed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_opening, label, maximum_filter, minimum_filter, uniform_filter

from pickcli.cell.place import Place
from pickcli.cell.sensors.sensor_model import DepthModel
from pickcli.geometry import Array, inverse, transform_points
from pickcli.perception.items.colour_model import colour_labels
from pickcli.perception.items.item_observation import FoundBy, Support, UnexplainedPart
from pickcli.perception.items.line_of_sight import LineOfSight, unexplained_depth
from pickcli.perception.items.place_pictures import (
    KnownSolids,
    PictureCosts,
    known_and_item_costs,
    place_picture,
)
from pickcli.perception.items.place_view import PlaceView
from pickcli.perception.items.pose_spread import PoseSpread, pose_spread
from pickcli.perception.items.pose_starts import (
    blind_starts,
    face_starts,
    part_starts,
    spread_points,
)
from pickcli.perception.items.product_model import ProductModel
from pickcli.perception.items.symmetry import displacement_between, faced_as
from pickcli.perception.surface_view import FloatPicture

_THINNED = 4.0  # pixels that one of the thinned view stands for
# No depth in the shadow of the second eye costs more while much is not found yet: another cause is as likely.
# Later a solid would be drawn over the shadow beside it.
_COARSE, _FINE = PictureCosts(0.004, 0.7, weight=_THINNED), PictureCosts(0.0015, 0.2)
_COARSE_STEPS = np.array([0.016, 0.008, 0.004])  # m
_FINE_STEPS = np.array([0.004, 0.002, 0.001, 0.0005, 0.00025])
_COARSE_PENETRATION, _FINE_PENETRATION = 0.004, 0.001  # m that items may reach into others
_LEAST_GAIN = 40.0  # nats, of an item that is placed
_N_SEEDS = (40, 15, 15)  # in each round
_N_SEARCHED, _N_KEPT = 24, 20  # starts that are moved, and options that are kept, of an item in a round
_POINT_SPACING = 0.028  # m between the points that starts are put on
_RAY_SPACING = 0.03  # between rays, at depth 1
_BEFORE = 0.004  # m before what is explained: a point of something else
_AROUND = 0.02  # m around the room
_OFTEN_LOST = 0.1  # share of a material from which nothing comes back, for starts without depth
_LOST_SHARE = 0.4  # of a block that was measured, below which it has no depth
_BADLY_EXPLAINED = 0.8  # nats of a pixel
_UNEXPLAINED = 0.012  # m before what is explained, of points that nothing explains
_THIN = 0.005  # m before it, of points that block the sight
_ODD, _ODD_AREA = 1.4, 7  # nats of a pixel in the mean over so many px square
_SPARSE, _MOSTLY = 0.2, 0.6  # shares of an area, and of what was measured in it, that are before
_LEAST_PART = 130  # pixels of 2 mm, of a part that is told
_NEAR, _COARSELY_NEAR = 0.006, 0.01  # m between a surface and what was measured of it
_LEAST_COLOURED = 20  # supported pixels of an item, from which on its colours are judged
_AT_PRINT = 0.015  # m of the surface, up to which a pose is the one in which its print was recognised
_SETTLED, _OFF = 0.5, 0.1  # shares of what an item shows that are supported at least, and off at most


@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """A pose of a listed item.

    Attributes:
        T_camera_item: (4, 4) in the camera's frame.
        support: How much of the picture speaks for it.
        found_by: By what it was found.
    """

    T_camera_item: Array
    support: Support
    found_by: FoundBy = FoundBy.SHAPE


@dataclass(frozen=True, eq=False)
class _Open:
    """What is not explained yet.

    Points (S, 3) with normals in the place's frame, rays (R, 3) without depth, and pixels that nothing
    explains.
    """

    points: Array
    normals: Array
    rays: Array
    is_open: NDArray[np.bool_]


class ItemSearch:
    """The search for the items of one place in one view.

    Args:
        place: The place.
        view: What was seen of it.
        models: Models of the listed items.
        solids: Known solids around.
        depth_model: How depth was measured.
        by_print: Poses (K, 4, 4) in the camera's frame in which prints were recognised, by index of the item,
            those with most matches first.
    """

    def __init__(
        self,
        place: Place,
        view: PlaceView,
        models: list[ProductModel],
        solids: KnownSolids,
        depth_model: DepthModel,
        by_print: Mapping[int, Array],
    ) -> None:
        self._by_print = by_print
        self._place, self._models, self._depth_model = place, models, depth_model
        self._T_camera_place, self._view = view.T_camera_place, view
        self._thin = view.thinned
        self._points, self._normals = self._thin.points, self._thin.normals
        costs = known_and_item_costs(place.carrier, models)
        labels = colour_labels(self._thin.colour)
        self._speaks_for = [own[labels] < 0.0 for own in costs[1:]]
        self._coarse = place_picture(self._thin, models, costs, solids, depth_model, _COARSE)
        self._fine = place_picture(view, models, costs, solids, depth_model, _FINE)

    def run(self) -> dict[int, PoseEstimate]:
        """Search for all items.

        Returns:
            Poses by index of the item; without items for which none explains the picture better.
        """
        n = len(self._models)
        up = self._T_camera_place[:3, 2]
        options = [self._by_print.get(i, np.zeros((0, 4, 4))) for i in range(n)]
        placed, poses, margins = np.zeros(0, dtype=np.int32), np.zeros((0, 4, 4)), np.zeros(n)
        is_settled = [False] * n
        for n_seeds in _N_SEEDS:
            options = self._with_new(options, placed, poses, is_settled, n_seeds)
            chosen, _, margins = self._coarse.choose(np.arange(n, dtype=np.int32), options, _LEAST_GAIN)
            placed = np.flatnonzero(chosen >= 0).astype(np.int32)
            poses = np.array([options[i][chosen[i]] for i in placed]).reshape(-1, 4, 4)
            poses = self._coarse.refined(placed, poses, up, _COARSE_STEPS, _COARSE_PENETRATION, 1)
            is_settled = self._settled(placed, poses)
            if all(is_settled):
                break
        poses = self._faced(placed, poses)
        poses = self._fine.refined(placed, poses, None, _FINE_STEPS, _FINE_PENETRATION, 2)
        poses = self._faced(placed, poses)  # some are near to one by print only now
        evidence = self._fine.evidence(placed, poses, _NEAR)
        own = self._own_colour_shares(placed, poses)
        return {
            int(i): PoseEstimate(
                T,
                _support(row, float(margins[i]), own[k], self._spread(placed, poses, k)),
                self._found_by(int(i), T),
            )
            for k, (i, T, row) in enumerate(zip(placed, poses, evidence, strict=True))
        }

    def _own_colour_shares(self, placed: NDArray[np.int32], poses: Array) -> list[float]:
        """Of each pose the share of its supported pixels with colours of the item; 1 of too few to tell."""
        owner, depth, _ = self._fine.composed(placed, poses)
        labels = colour_labels(self._view.colour)
        with np.errstate(invalid="ignore"):
            is_near = np.abs(self._view.depth - depth) <= _NEAR
        shares = []
        for k, i in enumerate(placed):
            seen = labels[is_near & (owner == k)]
            own = self._models[i].own_labels
            shares.append(float(own[seen].mean()) if len(seen) >= _LEAST_COLOURED else 1.0)
        return shares

    def _faced(self, placed: NDArray[np.int32], poses: Array) -> Array:
        """The poses with the faces of those near to them in which their prints were recognised."""
        faced = [self._seen_print(int(i), T) for i, T in zip(placed, poses, strict=True)]
        return np.array(
            [
                T if T_print is None else faced_as(self._models[i].item.shape, T, T_print)
                for i, T, T_print in zip(placed, poses, faced, strict=True)
            ]
        ).reshape(-1, 4, 4)

    def _seen_print(self, i: int, T: Array) -> Array | None:
        """Of poses (4, 4) near to one in which the print of an item was recognised that with most matches."""
        shape = self._models[i].item.shape
        by_print = self._by_print.get(i, ())
        return next((each for each in by_print if displacement_between(shape, T, each) < _AT_PRINT), None)

    def _found_by(self, i: int, T: Array) -> FoundBy:
        return FoundBy.SHAPE if self._seen_print(i, T) is None else FoundBy.PRINT

    def _spread(self, placed: NDArray[np.int32], poses: Array, k: int) -> PoseSpread:
        """How far one of the poses may be off, all others being right."""
        others = np.arange(len(placed)) != k
        return pose_spread(
            self._models[placed[k]].item.shape,
            poses[k],
            lambda moved: self._fine.costs(int(placed[k]), moved, (placed[others], poses[others])),
        )

    def unexplained(self, found: Mapping[int, Array]) -> tuple[UnexplainedPart, ...]:
        """Collect parts of the picture that neither the known place nor items explain.

        There something was measured before them; or depth is missing, or colours are others than expected,
        over a whole area.

        Args:
            found: Poses (4, 4) in the camera's frame that explain what they show, by index of the item.

        Returns:
            The parts, the largest first; where no depth was measured the surface behind tells where, and
            pixels without any do not count.
        """
        _, points, is_before, is_odd = self._left(found, _UNEXPLAINED)
        is_sparse = _sparsely_measured(is_before, np.isfinite(self._view.depth))
        labels, n_parts = label(_opened(is_before, 3) | is_sparse | is_odd)
        labels[~np.isfinite(points).all(axis=2)] = 0
        own = [points[labels == part] for part in range(1, n_parts + 1)]
        parts = [
            UnexplainedPart(len(each), each.min(axis=0), each.max(axis=0))
            for each in own
            if len(each) >= _LEAST_PART
        ]
        return tuple(sorted(parts, key=lambda part: -part.n_pixels))

    def line_of_sight(self, found: Mapping[int, Array], within: Mapping[int, float]) -> LineOfSight:
        """Compute how far rays are clear of what nothing explains.

        Args:
            found: Poses (4, 4) in the camera's frame that explain what they show, by index of the item.
            within: m by which points of these items may be elsewhere, by index of the item.

        Returns:
            The rays.
        """
        view = self._view
        depth, points, is_before, is_odd = self._left(found, _THIN)
        for i, T_camera_item in found.items():
            T_item_place = inverse(T_camera_item) @ self._T_camera_place
            shape = self._models[i].item.shape.inflated(within[i])
            is_before[is_before] = ~shape.contains(transform_points(T_item_place, points[is_before]))
        with np.errstate(invalid="ignore"):
            met = np.where(view.depth > depth, view.depth, depth)
        met = np.where(np.isfinite(depth), met, 0.0).astype(np.float32)
        blocked = unexplained_depth(view.depth, is_before, is_odd, _THIN)
        return LineOfSight(view.camera, self._T_camera_place, met, blocked)

    def _left(
        self, found: Mapping[int, Array], thickness: float
    ) -> tuple[FloatPicture, Array, NDArray[np.bool_], NDArray[np.bool_]]:
        """What items leave unexplained.

        Returns:
            Depth of what is explained (infinite where nothing is looked for), points in the place's frame,
            which of them are before that, and where colours or missing depth are odd over a whole area.
        """
        placed = np.array(sorted(found), dtype=np.int32)
        poses = np.array([found[int(i)] for i in placed]).reshape(-1, 4, 4)
        owner, depth, cost = self._fine.composed(placed, poses)
        room, view = self._place.room, self._view
        points = view.surface_points
        with np.errstate(invalid="ignore"):
            is_before = (view.depth < depth - thickness) & np.isfinite(depth)
            is_inside = ((points > room.low - _AROUND) & (points < room.high + _AROUND)).all(axis=-1)
        is_odd = (uniform_filter(cost, _ODD_AREA) > _ODD) & (owner < 0)
        is_odd = _opened(is_odd & is_inside, _ODD_AREA)
        return depth, points, is_before & is_inside, is_odd

    def _with_new(
        self,
        options: list[Array],
        placed: NDArray[np.int32],
        poses: Array,
        is_settled: list[bool],
        n_seeds: int,
    ) -> list[Array]:
        """Options with new ones among what is placed, and the refined poses of what is."""
        out: list[Array] = []
        # What nothing explains is the same for all items that are not placed.
        opened: dict[bytes, _Open] = {}
        for i, model in enumerate(self._models):
            first = next(k for k, other in enumerate(self._models) if other.item == model.item)
            if not len(placed) and first < i:
                out.append(out[first])
                continue
            new = options[i]
            if not is_settled[i]:
                others = placed != i
                key = placed[others].tobytes()
                if key not in opened:
                    opened[key] = self._open(placed[others], poses[others], n_seeds)
                new = np.concatenate([new, self._candidates(i, placed[others], poses[others], opened[key])])
            out.append(np.concatenate([new, poses[placed == i]]))
        return out

    def _candidates(self, i: int, placed: NDArray[np.int32], poses: Array, left: _Open) -> Array:
        """(N, 4, 4) options of an item among others that are placed, in the camera's frame."""
        model, T, room = self._models[i], self._T_camera_place, self._place.room
        shape, eye = model.item.shape, inverse(T)[:3, 3]
        starts = [
            face_starts(shape, left.points, left.normals, room),
            part_starts(
                shape, eye, self._thin.rays, binary_opening(left.is_open & self._speaks_for[i]), room
            ),
        ]
        if self._lost(i) > _OFTEN_LOST:
            starts.append(blind_starts(shape, eye, left.rays, room))
        every = np.concatenate([*starts, inverse(T) @ self._by_print.get(i, np.zeros((0, 4, 4)))])
        if not len(every):
            return every
        counts = (_N_SEARCHED, _N_KEPT)
        found, _ = self._coarse.candidates(i, T @ every, T[:3, 2], _COARSE_STEPS, counts, (placed, poses))
        is_inside = [self._place.holds(p, np.inf) for p in (inverse(T) @ found)[:, :3, 3]]
        return np.asarray(found[np.array(is_inside, dtype=bool)])

    def _open(self, placed: NDArray[np.int32], poses: Array, most: int) -> _Open:
        room = self._place.room
        owner, depth, cost = self._coarse.composed(placed, poses)
        with np.errstate(invalid="ignore"):
            is_item = (self._thin.depth < depth - _BEFORE) & np.isfinite(self._normals).all(axis=-1)
            is_item &= ((self._points >= room.low - _AROUND) & (self._points <= room.high + _AROUND)).all(
                axis=-1
            )
        is_open = (uniform_filter(cost, 3) > _THINNED * _BADLY_EXPLAINED) & (owner < 0)
        points, rays = self._points[is_item], self._thin.rays[is_open & (self._thin.share < _LOST_SHARE)]
        chosen = spread_points(points, _POINT_SPACING, most)
        return _Open(
            points[chosen],
            self._normals[is_item][chosen],
            rays[spread_points(rays, _RAY_SPACING, most)],
            is_open,
        )

    def _settled(self, placed: NDArray[np.int32], poses: Array) -> list[bool]:
        """Whether each item is where nearly all that it should show was measured, and nothing else."""
        settled = [False] * len(self._models)
        evidence = self._coarse.evidence(placed, poses, _COARSELY_NEAR)
        for i, (_, shown, supported, through, before, _, _) in zip(placed, evidence, strict=True):
            comes_back = (1.0 - self._lost(i)) * shown
            settled[i] = bool(supported > _SETTLED * comes_back and through + before < _OFF * shown)
        return settled

    def _lost(self, i: int) -> float:
        """Share of an item's surface from which nothing comes back."""
        return self._depth_model.no_return.get(self._models[i].item.material, 0.0)


def _sparsely_measured(is_before: NDArray[np.bool_], is_measured: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Areas in which most of the little that was measured is before what is explained: clear items are so.

    Where nothing came back a pixel tells nothing, so neighbours tell for it.
    """
    before, measured = (
        uniform_filter(each.astype(np.float32), _ODD_AREA) for each in (is_before, is_measured)
    )
    is_dense = (before > _SPARSE) & (before > _MOSTLY * measured)
    return _opened(is_dense & (is_before | ~is_measured), _ODD_AREA)


def _opened(is_set: NDArray[np.bool_], width: int) -> NDArray[np.bool_]:
    """The pixels of squares, so many px wide, of which all pixels are set: along rows, then along columns."""
    eroded = minimum_filter(is_set.view(np.uint8), width, mode="constant", cval=0)
    return np.asarray(maximum_filter(eroded, width, mode="constant", cval=0).view(np.bool_))


def _support(row: Array, margin: float, own_colour: float, spread: PoseSpread) -> Support:
    expected, shown, supported, through, before = (int(n) for n in row[:5])
    return Support(
        expected, shown, supported, through, before, float(row[5]), margin, float(row[6]),
        own_colour, spread.position, spread.angle, spread.surface,
    )  # fmt: skip
