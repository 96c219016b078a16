"""Deviations of the simulated world from its model, with one documented level per kind.

The planner never reads these levels. It knows bounds (``PoseNoise``, stated masses, the estimated pose of the
pod); this module decides what truly happens within or beyond them. docs/reality.md states the source of each
level and its cost in points.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, get_type_hints

from pydantic import Field, create_model

from pickcli.files.file_kind import REALITY
from pickcli.files.schema import FileModel, validate
from pickcli.files.yaml_reader import read_yaml
from pickcli.scene.scene_schema import MAX_POD_YAW, POD_YAW

Switch: TypeAlias = Annotated[bool, Field(description="true or false")]
Share: TypeAlias = Annotated[float, Field(ge=0.0, le=1.0, description="a share, 0 to 1")]
Scale: TypeAlias = Annotated[float, Field(ge=1.0, le=10.0, description="a factor, 1 to 10")]
Metres: TypeAlias = Annotated[float, Field(ge=0.0, le=0.1, description="m, 0 to 0.1")]
PodYaw: TypeAlias = Annotated[float, Field(ge=0.0, le=MAX_POD_YAW, description=POD_YAW)]
Seconds: TypeAlias = Annotated[float, Field(ge=0.0, le=60.0, description="s, 0 to 60")]


@dataclass(frozen=True)
class Reality:
    """Levels of the deviations between the simulated world and the planner's model.

    The defaults are realistic levels; ``IDEAL`` switches everything off.

    Attributes:
        pose_outlier_share: Share of the item poses in a measurement whose error exceeds the bound known to
            planning.
        pose_outlier_scale: Largest error of such a pose, as a multiple of the bound.
        pod_shift: Whether the pod is displaced at random within the cell's bounds.
        pod_position_error: Bound of the estimated pod position's error on the floor, m.
        pod_angle_error: Bound of the estimated pod yaw's error, rad.
        tote_shift: Whether the tote is displaced at random within what touches reach.
        tote_position_error: Bound of the estimated position's error of a displaced tote on its table, m.
        tote_angle_error: Bound of the estimated yaw's error of a displaced tote, rad.
        mass_error: Bound of the true mass's error, as a share of the stated mass.
        honest_seals: Whether faces leak as ``data/items`` states; otherwise every face seals airtight.
        compliant_cup: Whether the bellows resist compression like a spring, and comply under load; otherwise
            they compress without force and hold rigidly.
        servo: Whether joints lag individually, depending on their load, with finite torque; otherwise all
            joints lag equally, independent of load.
        look_time: Duration of one measurement of the shelf, s; of one picture, by a camera.
        hand_eye: Whether cameras are off their stated poses, within the bounds of the cell.
        supervision: Whether following error, contact and vacuum are supervised and stop the motion.
        damage_limits: Whether forces beyond the limits of items or the shelf count as damage in the score.
        operator_stop_share: Share of the motions that the operator stops once, at a random time, and resumes.
        deformed_looks: Whether cameras see cloth and bags rumpled, inside of the boxes that physics has.
        leaning_share: Share of the items that lean on walls and each other, of those in bins that can.
    """

    pose_outlier_share: Share = 0.02
    pose_outlier_scale: Scale = 3.0
    pod_shift: Switch = True
    pod_position_error: Metres = 0.002
    pod_angle_error: PodYaw = 0.00524
    tote_shift: Switch = False
    tote_position_error: Metres = 0.002
    tote_angle_error: PodYaw = 0.00524
    mass_error: Share = 0.10
    honest_seals: Switch = True
    compliant_cup: Switch = True
    servo: Switch = True
    look_time: Seconds = 1.0
    hand_eye: Switch = True
    supervision: Switch = True
    damage_limits: Switch = True
    operator_stop_share: Share = 0.0
    leaning_share: Share = 0.0
    deformed_looks: Switch = False

    def as_dict(self) -> dict[str, Any]:
        """Return all levels by name, as in files and in trial.json.

        Returns:
            Values by name.
        """
        return asdict(self)


DEFAULT = Reality()
IDEAL = Reality(
    pose_outlier_share=0.0,
    pod_shift=False,
    pod_position_error=0.0,
    pod_angle_error=0.0,
    tote_position_error=0.0,
    tote_angle_error=0.0,
    mass_error=0.0,
    honest_seals=False,
    compliant_cup=False,
    servo=False,
    look_time=0.0,
    hand_eye=False,
    damage_limits=False,
)


def read_reality(path: Path | None) -> Reality:
    """Read levels from a YAML file with the differences from the default.

    Args:
        path: File with ``format: apc reality``, ``version: 1`` and some of the levels; None for the default.

    Returns:
        The levels of the file, and the default for all others.

    Raises:
        InputError: The file cannot be read, or a name, type or range in it is wrong: with every mistake and
            its line and column.
    """
    if path is None:
        return DEFAULT
    model = validate(read_yaml(path, REALITY), _file_model())
    return Reality(**model.model_dump(exclude=set(RealityHead.model_fields)))


class RealityHead(FileModel):
    """Head of a file of levels."""

    format: Literal["apc reality"] = Field(description="'apc reality'")
    version: Literal[1] = Field(description="1, the only version there is")


@cache
def _file_model() -> type[RealityHead]:
    """Schema of a file: the levels above, with their types, ranges and defaults."""
    hints = get_type_hints(Reality, include_extras=True)
    levels: dict[str, Any] = {level.name: (hints[level.name], level.default) for level in fields(Reality)}
    return create_model("RealityModel", __base__=RealityHead, **levels)
