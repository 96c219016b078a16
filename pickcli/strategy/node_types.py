"""Types of nodes of which strategies consist, with their parameters.

Control nodes and decorators are those of behaviour trees (Colledanchise and Ögren, "Behavior Trees in
Robotics and AI", 2018, chapter 1); conditions and actions are those of a trial: of an order, or of a
commission.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum

MAX_COUNT = 1000
MAX_SECONDS = 1e5


class NodeKind(StrEnum):
    """Kind of a node, as in BehaviorTree.CPP."""

    CONTROL = "control"
    DECORATOR = "decorator"
    CONDITION = "condition"
    ACTION = "action"


class TrialKind(StrEnum):
    """Kind of the trials that a strategy plays."""

    ORDER = "order"  # items are brought from place to place
    COMMISSION = "commission"  # a truck fetches a pallet, its arm puts items on it, and it is delivered


class ParameterType(StrEnum):
    """Type of a parameter's value."""

    COUNT = "an integer from 1 to 1000"
    SECONDS = "seconds from 0 to 100000"
    CHOICE = "one of some words"
    CRITERIA = "a list of criteria"
    NAMES = "a list of names"


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node type.

    Attributes:
        type: Type of its value.
        choices: Words that are possible, for choices and criteria.
        is_required: Whether it must be stated.
    """

    type: ParameterType
    choices: tuple[str, ...] = ()
    is_required: bool = False


@dataclass(frozen=True)
class NodeType:
    """One type of node.

    Attributes:
        name: Name in strategy files.
        kind: Kind of the node, which decides whether it has children.
        xml_name: Name in BehaviorTree.CPP's XML format.
        summary: What it does, in one sentence.
        parameters: Its parameters, by name.
        trial: Kind of the trials in which it has a meaning; None for control nodes and decorators.
    """

    name: str
    kind: NodeKind
    xml_name: str
    summary: str
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    trial: TrialKind | None = None


class Criterion(StrEnum):
    """Criterion by which open targets are ordered; the first in the order is chosen."""

    POINTS_PER_SECOND = "points_per_second"  # most expected points per second first
    POINTS = "points"  # most points first
    FEWEST_ITEMS = "fewest_items"  # fewest items in the target's bin first
    FEWEST_ATTEMPTS = "fewest_attempts"
    ITEM_PRIORITY = "item_priority"  # by the list ``items``; other items last
    BIN_PRIORITY = "bin_priority"  # by the list ``bins``; other bins last
    ORDER = "order"  # by the lines of the order


class ActionKind(StrEnum):
    """What can be tried next for a target."""

    PICK = "pick"
    CLEAR = "clear"  # move a blocking item aside


class TruckGoal(StrEnum):
    """Where a truck is driven in a commission."""

    LOAD = "load"  # beside the load, from where the arm reaches it
    DELIVERY = "delivery"  # where the pallet is set down
    END = "end"  # out of the pallet, where the commission ends


_COUNT = Parameter(ParameterType.COUNT, is_required=True)
_CRITERIA = Parameter(ParameterType.CRITERIA, tuple(map(str, Criterion)), is_required=True)

_CONTROL = (
    NodeType(
        "sequence", NodeKind.CONTROL, "Sequence",
        "Ticks its children in order until one fails; succeeds if all do.",
    ),
    NodeType(
        "fallback", NodeKind.CONTROL, "Fallback",
        "Ticks its children in order until one succeeds; fails if all do.",
    ),
    NodeType(
        "retry", NodeKind.DECORATOR, "RetryUntilSuccessful",
        "Ticks its child again in the next tick after a failure, up to a number of attempts.",
        {"attempts": _COUNT},
    ),
    NodeType("invert", NodeKind.DECORATOR, "Inverter", "Fails if its child succeeds, and the reverse."),
    NodeType("force_success", NodeKind.DECORATOR, "ForceSuccess", "Succeeds even if its child fails."),
    NodeType(
        "deadline", NodeKind.DECORATOR, "Deadline",
        "Ticks its child only while at least so much time is left on the trial's clock, else fails.",
        {"seconds_left": Parameter(ParameterType.SECONDS, is_required=True)},
    ),
)  # fmt: skip

_OF_ORDERS = (
    NodeType(
        "has_time_to_plan", NodeKind.CONDITION, "HasTimeToPlan",
        "Whether one more planning call would end within the trial's time.",
    ),
    NodeType(
        "is_action", NodeKind.CONDITION, "IsAction",
        "Whether the chosen action is of a kind.",
        {"kind": Parameter(ParameterType.CHOICE, tuple(map(str, ActionKind)), is_required=True)},
    ),
    NodeType(
        "has_no_plan", NodeKind.CONDITION, "HasNoPlan",
        "Whether planning for the chosen target failed in the present scene.",
    ),
    NodeType(
        "attempts_below", NodeKind.CONDITION, "AttemptsBelow",
        "Whether fewer attempts than a number were made at the chosen target.",
        {"count": _COUNT},
    ),
    NodeType(
        "choose_action", NodeKind.ACTION, "ChooseAction",
        "Chooses the action with the most expected points per second, of all open targets; fails if none "
        "is worth trying.",
    ),
    NodeType(
        "choose_target", NodeKind.ACTION, "ChooseTarget",
        "Chooses the first open target by criteria, each of which decides between targets that are equal "
        "by those before it; fails if there is none.",
        {
            "by": _CRITERIA,
            "items": Parameter(ParameterType.NAMES),
            "bins": Parameter(ParameterType.NAMES),
            "attempts_below": Parameter(ParameterType.COUNT),
        },
    ),
    NodeType("look", NodeKind.ACTION, "Look", "Looks at the scene again; fails if there is no time."),
    NodeType(
        "pick", NodeKind.ACTION, "Pick",
        "Plans and executes one attempt at the chosen target; succeeds if it is delivered.",
    ),
    NodeType(
        "clear", NodeKind.ACTION, "Clear",
        "Moves one item aside that blocks the chosen target; succeeds if the target may be tried again.",
    ),
    NodeType("give_up", NodeKind.ACTION, "GiveUp", "Closes the chosen target: it is not tried again."),
)  # fmt: skip

# Of the chain of APPLE (Krug et al., RA-L 2016, Fig. 7).
_OF_COMMISSIONS = (
    NodeType(
        "enter_pallet", NodeKind.ACTION, "EnterPallet",
        "Plans a drive into the expected pallet and drives it, with looks at the pallet on the way; succeeds "
        "if the forks are in it.",
    ),
    NodeType("lift_pallet", NodeKind.ACTION, "LiftPallet", "Raises the forks with the pallet on them."),
    NodeType(
        "drive", NodeKind.ACTION, "Drive",
        "Plans a drive to a place and drives it; succeeds if the truck believes to stand there.",
        {"to": Parameter(ParameterType.CHOICE, tuple(map(str, TruckGoal)), is_required=True)},
    ),
    NodeType(
        "has_open_items", NodeKind.CONDITION, "HasOpenItems",
        "Whether an item of the commission is neither on the pallet, nor lost, nor given up.",
    ),
    NodeType(
        "is_item_open", NodeKind.CONDITION, "IsItemOpen",
        "Whether the chosen item is neither on the pallet, nor lost, nor given up.",
    ),
    NodeType(
        "choose_item", NodeKind.ACTION, "ChooseItem",
        "Chooses the open item whose place is filled first; fails if there is none.",
    ),
    NodeType(
        "look_at_load", NodeKind.ACTION, "LookAtLoad",
        "Looks at load, pallet and items from where the truck stands; fails if one of the two is farther off "
        "than the arm's cell allows.",
    ),
    NodeType(
        "transfer_item", NodeKind.ACTION, "TransferItem",
        "Plans, verifies and executes the way of the chosen item from the load to its place on the pallet; "
        "succeeds if it stands there.",
    ),
    NodeType(
        "skip_item", NodeKind.ACTION, "SkipItem",
        "Gives the chosen item up, if it is open: it stays where it is.",
    ),
    NodeType(
        "home_arm", NodeKind.ACTION, "HomeArm",
        "Plans, verifies and executes a move of the arm to its home; succeeds if it is there.",
    ),
    NodeType("set_down_pallet", NodeKind.ACTION, "SetDownPallet", "Lowers the forks with the pallet."),
    NodeType(
        "end_here", NodeKind.ACTION, "EndHere",
        "Ends the commission with the truck where it stands: nothing moves any more.",
    ),
)  # fmt: skip

NODE_TYPES = {
    each.name: each
    for each in (
        *_CONTROL,
        *(replace(each, trial=TrialKind.ORDER) for each in _OF_ORDERS),
        *(replace(each, trial=TrialKind.COMMISSION) for each in _OF_COMMISSIONS),
    )
}
