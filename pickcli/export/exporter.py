"""What turns a verified plan into the bytes of a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pickcli.motion.plan import Plan
    from pickcli.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """What is to be written.

    Attributes:
        plan: The plan, verified for the scene; its events are resolved.
        scene: What stands around the robot, and the cell as the plan's arm sees it.
        rate: Hz of the samples; None for the plan's own points.
        channels: Number of the digital output or input of a device, by its name, where the user chose it.
    """

    plan: Plan
    scene: Scene
    rate: float | None = None
    channels: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Exporter:
    """One format. Installed packages add theirs as entry points of the group ``apc.exporters``.

    Attributes:
        description: What is written, in one line.
        suffix: Of the files, with its dot.
        encode: From a request to the whole file. The same request gives the same bytes. What the format
            cannot hold is refused with an InputError.
        has_channels: Whether it writes numbers of outputs and inputs.
    """

    description: str
    suffix: str
    encode: Callable[[ExportRequest], bytes]
    has_channels: bool = False
