"""Reads stacks of tasks, such as those under data/stacks. See docs/formats/stack.md."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from pickcli.cell.data_path import data_file
from pickcli.cell.schemas.pose_schema import Name
from pickcli.cell.tool import ToolState
from pickcli.collision.kernel_validator import KernelValidator
from pickcli.control.roll_out import Stack
from pickcli.control.tasks.joint_limit_task import JointLimitTask
from pickcli.control.tasks.obstacle_task import ObstacleTask
from pickcli.control.tasks.posture_task import PostureTask
from pickcli.control.tasks.task import Task
from pickcli.control.tasks.tool_task import ToolTask
from pickcli.errors import UnknownNameError
from pickcli.files.file_kind import STACK
from pickcli.files.schema import FileModel, Text, validate
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm, ToolGoal

GIVEN = "given"  # configuration of a posture that whoever runs the stack provides

Gain = Annotated[float, Field(gt=0, le=1000)]
Distance = Annotated[float, Field(ge=0, le=1)]


class JointLimitTaskModel(FileModel):
    """Limits of positions, rates and accelerations."""

    kind: Literal["joint_limits"] = Field(description="'joint_limits'")
    speed_scale: Annotated[float, Field(gt=0, le=1)] = Field(
        1.0, description="share of rates and accelerations"
    )


class ObstacleTaskModel(FileModel):
    """Distances from what is near."""

    kind: Literal["obstacles"] = Field(description="'obstacles'")
    wanted: Distance = Field(description="m, kept from solids")
    between_links: Distance = Field(description="m, that links keep from each other")
    influence: Distance = Field(description="m, at which something begins to count")
    gain: Gain = Field(description="1/s")


class EnvelopeTaskModel(FileModel):
    """The envelope of the item that is grasped."""

    kind: Literal["envelope"] = Field(description="'envelope'")
    gain: Gain = Field(description="1/s")
    inside: Annotated[float, Field(gt=0, le=0.1)] = Field(
        1e-3, description="m or difference of cosines beyond the bounds that is aimed at"
    )


class PostureTaskModel(FileModel):
    """A configuration to which the joints are drawn."""

    kind: Literal["posture"] = Field(description="'posture'")
    to: Text = Field(description="name of a configuration of the cell; `given` for that of a plan")
    gain: Gain = Field(description="1/s")


TaskModel = Annotated[
    JointLimitTaskModel | ObstacleTaskModel | EnvelopeTaskModel | PostureTaskModel,
    Field(discriminator="kind"),
]


class LevelModel(FileModel):
    """Tasks of one priority."""

    tasks: Annotated[list[TaskModel], Field(min_length=1, max_length=10)] = Field(
        description="tasks that are met together as well as possible"
    )


class StackModel(FileModel):
    """A whole file of a stack."""

    format: Literal["apc stack"] = Field(description="'apc stack'")
    version: Literal[1] = Field(description="1, the only version there is")
    name: Name = Field(description="the stack's name")
    period: Annotated[float, Field(ge=0.001, le=0.1)] = Field(
        0.01, description="s between instants of control"
    )
    goal: Literal["envelope", "posture"] = Field(description="the task that ends a roll-out when it is met")
    levels: Annotated[list[LevelModel], Field(min_length=1, max_length=20)] = Field(
        description="the levels, the most important one first"
    )

    @model_validator(mode="after")
    def _is_sound(self) -> StackModel:
        names = [task.kind for level in self.levels for task in level.tasks]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"expected each task once, got {', '.join(twice)} more than once; remove one")
        if self.goal not in names:
            raise ValueError(f"expected the goal {self.goal} among the tasks, got {', '.join(names)}; add it")
        for task in (task for level in self.levels for task in level.tasks):
            if isinstance(task, ObstacleTaskModel) and task.influence <= max(task.wanted, task.between_links):
                raise ValueError(
                    f"expected an influence beyond what is wanted, got {task.influence:g} m; raise it"
                )
            gain = getattr(task, "gain", 0.0)
            if gain * self.period >= 1.0:
                most = f"{1 / self.period:g}, at which one period overshoots"
                raise ValueError(
                    f"expected a gain of {task.kind} below {most}, got {gain:g}; lower it or the period"
                )
        return self


@dataclass(frozen=True, eq=False)
class ControlledArm:
    """What the tasks of a stack need besides their file.

    Attributes:
        arm: The arm.
        tool_state: State of the tool.
        validator: The arm in its scene.
        configurations: Named configurations (n,) of the cell.
    """

    arm: Arm
    tool_state: ToolState
    validator: KernelValidator
    configurations: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class StackFile:
    """A stack as its file states it.

    Attributes:
        name: Its name.
        period: s between instants of control.
        task_names: Names of the tasks of each level.
        model: The file's content.
    """

    name: str
    period: float
    task_names: tuple[tuple[str, ...], ...]
    model: StackModel

    def stack(self, controlled: ControlledArm, goal: ToolGoal | None = None) -> Stack:
        """Make the stack for an arm and an object.

        Args:
            controlled: The arm.
            goal: The envelope, with the object's pose; None for a stack without one.

        Returns:
            The stack.

        Raises:
            UnknownNameError: A posture names no configuration of the cell.
            ValueError: The stack has an envelope, and none is given.
        """
        limits = controlled.arm.limits
        make: dict[type[FileModel], Callable[..., Task]] = {
            JointLimitTaskModel: lambda m: JointLimitTask(m.kind, limits, m.speed_scale),
            ObstacleTaskModel: lambda m: ObstacleTask(
                m.kind,
                controlled.validator,
                m.wanted,
                m.between_links,
                m.influence,
                m.gain,
                limits.acceleration,
            ),
            EnvelopeTaskModel: lambda m: ToolTask(
                m.kind, controlled.arm, controlled.tool_state, self._given(goal), m.gain, m.inside
            ),
            PostureTaskModel: lambda m: PostureTask(m.kind, self._named(controlled, m.to), m.gain),
        }
        levels = tuple(tuple(make[type(task)](task) for task in level.tasks) for level in self.model.levels)
        return Stack(levels, self.model.goal, limits.acceleration)

    def _given(self, goal: ToolGoal | None) -> ToolGoal:
        if goal is None:
            raise ValueError(f"stack {self.name} has an envelope, and none is given")
        return goal

    def _named(self, controlled: ControlledArm, name: str) -> Array:
        if name not in controlled.configurations:
            known = list(controlled.configurations)
            where = f"stack {self.name}, posture"
            given = (
                "the configuration is given by a plan, as by apc plan-pick --approach reactive; to let the "
                f"stack run alone, name one of the cell in a copy of its file: {', '.join(known)}"
            )
            raise UnknownNameError("configuration", name, known, where, text=given if name == GIVEN else "")
        return controlled.configurations[name]


def read_stack(path: Path) -> StackFile:
    """Read the file of a stack.

    Args:
        path: The file.

    Returns:
        The stack as the file states it.

    Raises:
        InputError: With every mistake and its position.
    """
    model = validate(read_yaml(path, STACK), StackModel)
    names = tuple(tuple(task.kind for task in level.tasks) for level in model.levels)
    return StackFile(model.name, model.period, names, model)


def stack_file(name: str) -> Path:
    """Return the file of a stack.

    Args:
        name: A name under data/stacks, or a path.

    Returns:
        The file.

    Raises:
        UnknownNameError: No stack has that name.
    """
    return data_file("stack", "stacks", name)
