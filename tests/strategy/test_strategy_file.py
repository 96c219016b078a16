"""Files of strategies: every mistake is reported with its place and what to write, and files round trip."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.errors import InputError
from pickcli.strategy.node_types import NODE_TYPES, NodeKind, TrialKind
from pickcli.strategy.strategy_file import (
    find_strategy,
    load_strategy,
    packaged_strategies,
    read_strategy,
)
from pickcli.strategy.strategy_svg import strategy_svg
from pickcli.strategy.strategy_text import strategy_text
from pickcli.strategy.strategy_tree import Strategy, StrategyNode
from pickcli.strategy.strategy_xml import strategy_xml

GOOD = """format: apc strategy
version: 1
name: own
description: mine
tree:
  sequence:
    - choose_target: {by: [order]}
    - {force_success: {child: pick}}
"""
FORMAT_PAGE = Path("docs/formats/strategy.md")


CHILD = "force_success: {child: pick}"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "pick}",
            "pik}",
            "8:24: tree.sequence[1].force_success.child: unknown node 'pik'; did you mean",
        ),
        ("by: [order]", "by: [ordr]", "by[0]: unknown criterion 'ordr'; did you mean 'order'?"),
        ("by: [order]", "to: [order]", "unknown parameter of choose_target; known: "),
        ("by: [order]", "", "the parameter by is missing: expected `choose_target: {by: [points, order]}`"),
        ("{child: pick}", "pick", "expected `force_success: {child: pick}`"),
        ("{child: pick}", "{}", "the key child is missing: expected `force_success: {child: pick}`"),
        ("sequence:", "sequense:", "6:3: tree.sequense: unknown node 'sequense'; did you mean 'sequence'?"),
        (CHILD, "retry: {attempts: 0, child: pick}", "expected an integer from 1 to 1000, got 0"),
        (CHILD, "is_action: {kind: push}", "expected one of pick, clear, got 'push'"),
        (CHILD, "pick: 3", "expected only the name, `pick`"),
        (CHILD, "pick: {fast: true}", "unknown parameter of pick; it has no parameters"),
        ("by: [order]", "by: [item_priority]", "the criterion item_priority needs a list `items: [...]`"),
        ("[order]", "[order], items: [a]", "is used only by the criterion item_priority: add that to `by`"),
        ("by: [order]", "by: [order, order]", "by[1]: order is listed twice"),
        ("name: own", 'name: "a\\x01b"', "name: expected one line of text, 1 to 2000 characters"),
        (
            CHILD,
            "deadline: {seconds_left: 200000, child: pick}",
            "expected seconds from 0 to 100000, got 200000",
        ),
        ("version: 1", "version: 2", "2:1: version: expected 1, got 2"),
        ("version: 1", "version: true", "2:1: version: expected 1, got True"),
        ("name: own", "name: ''", "name: expected one line of text, 1 to 2000 characters"),
        ("description: mine", "descripton: mine", "unknown key; did you mean 'description'?"),
        (CHILD, "pick: , look: ", "expected one node: a name such as pick, or `sequence: [...]`"),
    ],
)
def test_a_mistake_is_reported_with_its_place_and_a_remedy(
    old: str, new: str, message: str, tmp_path: Path
) -> None:
    assert old in GOOD
    path = tmp_path / "own.yaml"
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(InputError) as caught:
        read_strategy(path)
    assert message in str(caught.value)
    assert all(str(path) in line for line in str(caught.value).splitlines())


def test_all_mistakes_are_reported_at_once(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text(
        GOOD.replace("pick}", "pik}").replace("[order]", "[ordr]").replace("version: 1", "version: 3")
    )
    with pytest.raises(InputError) as caught:
        read_strategy(path)
    assert len(str(caught.value).splitlines()) == 3


def test_what_is_no_mapping_and_what_is_too_large_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text("- pick\n")
    with pytest.raises(InputError, match="expected the keys format, version"):
        read_strategy(path)
    path.write_text(GOOD.split("  sequence")[0] + "  sequence: [" + "look, " * 600 + "look]\n")
    with pytest.raises(InputError, match="more than 500 nodes"):
        read_strategy(path)


def test_a_file_of_another_kind_is_named_as_what_it_is() -> None:
    with pytest.raises(InputError, match="a cell"):
        read_strategy(Path("data/cells/apc2016_delft/cell.yaml"))


def test_packaged_strategies_are_found_by_name_and_unknown_ones_are_not() -> None:
    assert packaged_strategies() == ("delft", "kth", "points")
    assert all(load_strategy(name).name == name for name in packaged_strategies())
    with pytest.raises(InputError, match=r"unknown strategy 'delf'; did you mean 'delft'\? Or name a file"):
        load_strategy("delf")
    with pytest.raises(InputError, match=r"mine\.yaml"):
        load_strategy("mine.yaml")
    with pytest.raises(InputError, match=r"did you mean 'apple'\? Or name a file"):
        find_strategy("appel")


@pytest.mark.parametrize("name", packaged_strategies())
def test_xml_has_the_nodes_of_the_tree_in_their_order(name: str) -> None:
    """Read back by the names of BehaviorTree.CPP, the tree is the same."""
    strategy = load_strategy(name)
    root = ElementTree.fromstring(strategy_xml(strategy))
    assert root.attrib == {"BTCPP_format": "4", "main_tree_to_execute": name}
    tree, models = root
    assert _names(tree[0]) == _named(strategy.root)
    custom = {model.attrib["ID"] for model in models}
    leaves = {
        n.type.xml_name for n in strategy.root.walk() if n.type.kind in (NodeKind.CONDITION, NodeKind.ACTION)
    }
    assert leaves <= custom
    ports = {model.attrib["ID"]: {port.attrib["name"] for port in model} for model in models}
    for element in tree.iter():
        if element.tag in ("Condition", "Action"):
            assert set(element.attrib) - {"ID"} <= ports[element.attrib["ID"]]


def trees() -> st.SearchStrategy[StrategyNode]:
    leaf = st.sampled_from(
        [StrategyNode("look"), StrategyNode("pick"), StrategyNode("attempts_below", {"count": 100})]
    )
    control = st.sampled_from(["sequence", "fallback"])
    return st.recursive(
        leaf,
        lambda inner: st.builds(
            lambda name, children: StrategyNode(name, {}, tuple(children)),
            control, st.lists(inner, min_size=1, max_size=3),
        ) | st.builds(lambda child: StrategyNode("deadline", {"seconds_left": 12345.5}, (child,)), inner),
        max_leaves=12,
    )  # fmt: skip


@given(trees())
def test_no_drawing_has_boxes_that_overlap(root: StrategyNode) -> None:
    check_drawing(Strategy("own", "", root))


@pytest.mark.parametrize("name", packaged_strategies())
def test_the_drawing_has_a_box_for_each_node_and_none_overlap(name: str) -> None:
    check_drawing(load_strategy(name))


def check_drawing(strategy: Strategy) -> None:
    root = ElementTree.fromstring(strategy_svg(strategy))
    boxes = [
        tuple(float(box.attrib[key]) for key in ("x", "y", "width", "height"))
        for box in root.iter("{http://www.w3.org/2000/svg}rect")
        if "x" in box.attrib
    ]
    assert len(boxes) == sum(1 for _ in strategy.root.walk())
    width, height = (float(root.attrib[key]) for key in ("width", "height"))
    for k, (x, y, w, h) in enumerate(boxes):
        assert x >= 0 and x + w <= width and y >= 0 and y + h <= height
        for X, Y, W, H in boxes[:k]:
            assert x >= X + W or x + w <= X or y >= Y + H or y + h <= Y


def test_the_text_has_one_line_for_each_node() -> None:
    strategy = load_strategy("points")
    lines = strategy_text(strategy).splitlines()[2:]
    assert len(lines) == sum(1 for _ in strategy.root.walk())
    assert lines[0] == "sequence" and lines[1] == "├─ ? has_time_to_plan"


def test_the_page_of_the_format_lists_every_node_with_its_parameters() -> None:
    page = FORMAT_PAGE.read_text()
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*)$", page, re.MULTILINE))
    for type_ in NODE_TYPES.values():
        assert type_.name in rows, type_.name
        assert all(f"`{name}`" in rows[type_.name] for name in type_.parameters), type_.name


def _names(element: ElementTree.Element) -> list[object]:
    own = element.attrib.get("ID", element.tag)
    return [own, *(_names(child) for child in element)]


def _named(node: StrategyNode) -> list[object]:
    return [node.type.xml_name, *(_named(child) for child in node.children)]


def test_a_file_that_mixes_trials_is_refused_with_the_node(tmp_path: Path) -> None:
    path = tmp_path / "mixed.yaml"
    path.write_text(
        "format: apc strategy\nversion: 1\nname: mixed\ndescription: both\n"
        "tree:\n  sequence: [enter_pallet, look, lift_pallet]\n"
    )
    with pytest.raises(
        InputError, match=r"look is of trials of the kind order, nodes before it of the kind comm"
    ):
        read_strategy(path)


def test_strategies_of_commissions_are_found_apart_from_those_of_orders() -> None:
    assert packaged_strategies(TrialKind.COMMISSION) == ("apple",)
    assert load_strategy("apple", TrialKind.COMMISSION).kind is TrialKind.COMMISSION
    assert find_strategy("apple").name == "apple" and find_strategy("kth").kind is TrialKind.ORDER
    with pytest.raises(InputError, match="apple: is a strategy of trials of the kind commission"):
        load_strategy("apple")
    with pytest.raises(InputError, match="kth: is a strategy of trials of the kind order"):
        load_strategy("kth", TrialKind.COMMISSION)
    with pytest.raises(InputError, match="apple"):
        load_strategy("aple", TrialKind.COMMISSION)
