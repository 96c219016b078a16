"""Interface of exporters, which convert a verified plan to the bytes of a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pickcli.motion.plan import Plan
    from pickcli.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """Input of an exporter.

    Attributes:
        plan: The plan, verified for the scene, with resolved events.
        scene: The scene of the plan, with the cell as seen by the plan's arm.
        rate: Hz of the samples; None for the plan's own points.
        channels: Numbers of digital outputs or inputs chosen by the user, by device.
    """

    plan: Plan
    scene: Scene
    rate: float | None = None
    channels: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Exporter:
    """An export format. Installed packages add formats as entry points of the group ``apc.exporters``.

    Attributes:
        description: Content of the file, in one line.
        suffix: Suffix of the files, with its dot.
        encode: Function from a request to the bytes of the file, which must be deterministic. It raises
            InputError for content that the format cannot represent.
        has_channels: Whether it uses numbers of outputs and inputs.
    """

    description: str
    suffix: str
    encode: Callable[[ExportRequest], bytes]
    has_channels: bool = False
