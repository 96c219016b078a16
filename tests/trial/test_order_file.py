"""Official orders: the real ones are read, wrong ones are refused with what, where and what to do."""

from __future__ import annotations

import json
from pathlib import Path
from time import process_time
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.errors import InputError, UnknownNameError
from pickcli.trial.order import Order, OrderKind, Target
from pickcli.trial.order_file import BINS, order_file, order_names, read_order
from pickcli.trial.output_file import order_text
from support.order_builders import ITEMS, parsed_order, pick_data

FILE = Path("o.json")
INVALID = sorted((Path(__file__).parent / "invalid_orders").glob("*.json"))


def parse(data: Any) -> Order:
    """Parse JSON data as an order."""
    return parsed_order(json.dumps(data), FILE, ITEMS)


def refusal(data: Any) -> str:
    """The message with which JSON data are refused."""
    with pytest.raises(InputError) as caught:
        parse(data)
    return str(caught.value)


@st.composite
def orders(draw: st.DrawFn) -> Order:
    """Any consistent order of any kind and year."""
    names = st.lists(st.sampled_from(ITEMS), max_size=4).map(tuple)
    contents = {name: draw(names) for name in BINS}
    copies = [Target(b, item) for b, items in contents.items() for item in items]
    n_targets = draw(st.integers(0, min(12, len(copies))))
    targets = tuple(draw(st.permutations(copies))[:n_targets]) if copies else ()
    if targets:
        return Order(OrderKind.PICK, draw(st.sampled_from([2015, 2016])), contents, (), targets)
    tote = draw(names)
    return Order(OrderKind.STOW if tote else OrderKind.OUTPUT, 2016, contents, tote, ())


@given(orders())
def test_round_trip(order: Order) -> None:
    assert parsed_order(order_text(order), FILE, ITEMS) == order


@settings(max_examples=300)
@given(orders(), st.data())
def test_mutated_bytes_are_an_order_or_an_input_error(order: Order, data: st.DataObject) -> None:
    text = bytearray(order_text(order).encode())
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(text)))
        end = data.draw(st.integers(start, min(len(text), start + 30)))
        text[start:end] = data.draw(
            st.binary(max_size=3) | st.sampled_from([b"null", b"[]", b'""', b"{}", b"7"])
        )
    try:
        mutated = parsed_order(text.decode("utf-8", "replace"), FILE, ITEMS)
    except InputError as error:
        assert "o.json" in str(error)
    else:
        assert parsed_order(order_text(mutated), FILE, ITEMS) == mutated


@settings(max_examples=100)
@given(st.recursive(
    st.none() | st.integers() | st.sampled_from([*ITEMS, *BINS, "bin_Z"]),
    lambda v: st.lists(v, max_size=3) | st.dictionaries(
        st.sampled_from(["bin_contents", "tote_contents", "work_order", "bin", "item", *BINS]), v, max_size=4
    ),
))  # fmt: skip
def test_any_json_is_an_order_or_an_input_error(data: Any) -> None:
    with pytest.raises(InputError, match=r"o\.json"):  # too few bins to be valid, whatever it is
        parse(data)


@pytest.mark.parametrize("path", INVALID, ids=lambda p: p.stem)
def test_real_files_with_errors_are_refused(path: Path) -> None:
    with pytest.raises(InputError) as caught:
        parsed_order(path.read_text(), Path(path.name), ITEMS)
    message = str(caught.value)
    line, column = (int(part) for part in message.split(":")[1:3])
    text = path.read_text().splitlines()
    assert 0 < column <= len(text[line - 1])
    if "//" in path.read_text():
        assert "no comments" in message
        assert text[line - 1][column - 1 :].startswith("//")


def test_there_are_real_files_with_errors() -> None:
    assert len(INVALID) == 5


def test_a_misspelt_key_is_suggested_once() -> None:
    data = pick_data()
    data["word_order"] = data.pop("work_order")
    assert "word_order: unknown key; did you mean 'work_order'?" in refusal(data)


def test_a_misspelt_bin_or_item_is_suggested() -> None:
    data = pick_data()
    data["work_order"][0]["item"] = "crayola_24ct"
    assert "unknown item 'crayola_24ct'; did you mean 'crayola_24_ct'?" in refusal(data)
    data = pick_data()
    data["bin_contents"]["bin_M"] = data["bin_contents"].pop("bin_L")
    message = refusal(data)
    assert "bin_contents.bin_M: unknown bin; did you mean 'bin_L'?" in message
    data = pick_data()
    data["work_order"][0]["bin"] = "binA"
    assert "did you mean 'bin_A'?" in refusal(data)


def test_a_missing_key_is_named() -> None:
    data = pick_data()
    del data["bin_contents"]["bin_C"]
    assert "bin_contents: the bin 'bin_C' is missing; add it (\"bin_C\": [] if empty)" in refusal(data)
    del data["bin_contents"]
    assert "bin_contents: expected an object with a list of items for every bin, got nothing" in refusal(data)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("bin_c", "bin_C"),
        ("A", "bin_A"),
        ("l", "bin_L"),
        ("Bin K", "bin_K"),
        ("bin-f", "bin_F"),
        ("binA", "bin_A"),
    ],
)
def test_a_bin_in_other_letters_is_understood(name: str, meant: str) -> None:
    data = pick_data()
    data["work_order"][0]["bin"] = name
    assert f"work_order[0].bin: unknown bin {name!r}; did you mean {meant!r}?" in refusal(data)
    data = pick_data()
    data["bin_contents"][name] = data["bin_contents"].pop(meant)
    assert f"bin_contents.{name}: unknown bin; did you mean {meant!r}?" in refusal(data)


@pytest.mark.parametrize(
    ("name", "meant"),
    [("Crayola 24 ct", "crayola_24_ct"), ("duct_tape", "scotch_duct_tape"), ("bottle", "dasani_water_bottle"),
     ("dove_beuaty_bar", "dove_beauty_bar")],
)  # fmt: skip
def test_an_item_in_other_words_is_understood(name: str, meant: str) -> None:
    assert f"unknown item {name!r}; did you mean {meant!r}?" in refusal(pick_data(bin_B=[name]))


def test_what_is_python_is_told_how_json_writes_it() -> None:
    for wrong, right in (("None", "null"), ("True", "true"), ("False", "false")):
        with pytest.raises(InputError, match=f"not JSON: {wrong} is Python; JSON writes {right}"):
            parsed_order(f'{{"bin_contents": {wrong}}}', FILE, ITEMS)


def test_a_number_of_any_length_is_told_in_plain_words() -> None:
    with pytest.raises(InputError) as caught:
        parsed_order('{"tote_contents": [%s]}' % ("9" * 5000), FILE, ITEMS)
    assert "tote_contents[0]: expected a number, got 999" in str(caught.value)
    assert "(5000 characters), which is too large; correct it" in str(caught.value)
    assert "sys" not in str(caught.value) and len(str(caught.value)) < 250


def test_a_target_lacks_its_item() -> None:
    data = pick_data()
    del data["work_order"][0]["item"]
    assert "work_order[0].item: expected the name of an item, got nothing; add it" in refusal(data)


def test_an_item_that_is_elsewhere_is_said_to_be_there() -> None:
    data = pick_data(bin_C=["dove_beauty_bar"])
    data["work_order"][0]["item"] = "dove_beauty_bar"
    message = refusal(data)
    assert "is ordered from bin_A but is not there (it is in bin_C)" in message


def test_two_targets_need_two_copies() -> None:
    target = {"bin": "bin_A", "item": "crayola_24_ct"}
    data = pick_data()
    data["work_order"] = [target, target]
    assert "is ordered 2 times from bin_A, which holds 1" in refusal(data)
    data["bin_contents"]["bin_A"] = ["crayola_24_ct"] * 2
    assert parse(data).work_order == (Target("bin_A", "crayola_24_ct"),) * 2


def test_all_problems_are_named_at_their_own_places() -> None:
    text = json.dumps(pick_data(bin_B=["x"], bin_C=["y"]), indent=1)
    with pytest.raises(InputError) as caught:
        parsed_order(text, FILE, ITEMS)
    found = {name: text.splitlines()[int(line.split(":")[1]) - 1] for line in str(caught.value).splitlines()
             for name in "xy" if f"item '{name}'" in line}  # fmt: skip
    assert found["x"].strip().startswith('"x"')
    assert found["y"].strip().startswith('"y"')


def test_a_long_list_of_problems_is_cut() -> None:
    message = refusal(pick_data(**{name: ["x"] * 50 for name in BINS}))
    assert len(message.splitlines()) == 21
    assert "more" in message.splitlines()[-1]


def test_kind_and_year_follow_the_format() -> None:
    data = pick_data()
    assert (parse(data).kind, parse(data).year) == (OrderKind.PICK, 2016)
    del data["tote_contents"]
    assert parse(data).year == 2015
    stow = pick_data() | {"tote_contents": ["jane_eyre_dvd"]}
    del stow["work_order"]
    assert parse(stow).kind is OrderKind.STOW
    assert parse(stow | {"tote_contents": []}).kind is OrderKind.OUTPUT
    del stow["tote_contents"]
    assert "neither 'work_order' nor 'tote_contents'" in refusal(stow)


def test_control_characters_cannot_reach_the_terminal() -> None:
    message = refusal(pick_data(bin_B=["\x1b[31mred\ud800"]))
    assert message.isprintable() or "\x1b" not in message
    message.encode("utf-8")


def test_orders_have_bounds() -> None:
    """Thousands of copies, targets or mistakes cost neither minutes nor memory."""
    copies = {bin_name: [ITEMS[0]] * (101 if bin_name == "bin_A" else 0) for bin_name in BINS}
    assert "bin_A: expected at most 100 entries, got 101" in refusal(
        {"bin_contents": copies, "tote_contents": [ITEMS[0]]}
    )
    target = {"bin": "bin_A", "item": ITEMS[0]}
    few = copies | {"bin_A": [ITEMS[0]] * 100}
    asked = refusal({"bin_contents": few, "tote_contents": [], "work_order": [target] * 7000})
    assert "at most 500 entries, got 7000" in asked
    began = process_time()
    bins = copies | {"bin_A": []} | {f"b{i}": [] for i in range(30_000)}
    for data in (
        {"bin_contents": bins, "tote_contents": []},
        {"bin_contents": {}, "tote_contents": [f"i{i}" for i in range(100)], "work_order": [target] * 500},
        {"bin_contents": {name: ["x" * 90] * 90 for name in BINS}, "tote_contents": []},
    ):
        lines = refusal(data).splitlines()
        assert len(lines) == 21 and "and " in lines[-1]
    assert process_time() - began < 5.0


def test_an_order_is_found_by_its_name_or_its_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "kth_2015_example" in order_names() == sorted(order_names())
    assert order_file(Path("kth_2015_example")) == data_path() / "tasks" / "kth_2015_example.json"
    for path in (Path("missing.json"), Path("some/folder"), tmp_path / "missing"):
        assert order_file(path) == path, "what can only be a path is taken as one"
    with pytest.raises(UnknownNameError, match="kth_2015_example"):
        order_file(Path("kth_2015_exampel"))
    Path("mine.json").write_text("{}")
    for written in (Path("mine"), tmp_path / "mine"):
        with pytest.raises(UnknownNameError) as caught:
            order_file(written)
        assert f"did you mean the file '{written}.json'?" in str(caught.value)
    Path("kth_2015_example.json").write_text("{}")
    assert order_file(Path("kth_2015_example")).parent == data_path() / "tasks", "a known name goes first"
    Path("kth_2015_example").write_text("{}")
    assert order_file(Path("kth_2015_example")) == Path("kth_2015_example"), "a file that is there goes first"


def test_an_order_is_read_for_the_bins_and_items_of_a_cell() -> None:
    cell = load_cell("apc2016_delft")
    order = read_order(Path("kth_2015_example"), cell)
    assert (order.kind, order.year, len(order.work_order)) == (OrderKind.PICK, 2015, 12)
    assert all(t.item in order.bin_contents[t.bin] for t in order.work_order)


@pytest.mark.parametrize("n_wrong", [1, 19, 20, 21, 90])
def test_twenty_problems_are_told_and_the_others_counted(n_wrong: int) -> None:
    lines = refusal(pick_data(bin_B=[f"no_such_item_{i}" for i in range(n_wrong)])).splitlines()
    assert len(lines) == min(n_wrong, 20) + (n_wrong > 20)
    assert n_wrong <= 20 or lines[-1] == f"o.json: and {n_wrong - 20} more"


@pytest.mark.parametrize(
    ("work_order", "problem"),
    [
        ([], "the work order is empty; name a target"),
        ([{"bin": "bin_Z", "item": "crayola_24_ct"}], "unknown bin 'bin_Z'"),
        ([{"bin": "bin_A", "item": "no_such_thing"}], "unknown item 'no_such_thing'"),
        ([{"bin": "bin_A"}], "[0].item: expected the name of an item, got nothing; add it"),
        ([{"item": "crayola_24_ct"}], "[0].bin: expected the name of a bin, got nothing; add it"),
        ([{"bin": 3, "item": "crayola_24_ct"}], "bin: expected the name of a bin: text in quotes, got 3"),
        ([5], "work_order[0]: expected an object {...}, got 5; correct it"),
        ({}, "work_order: expected a list of targets, each with its bin and item, got {}"),
        ([{"bin": "bin_B", "item": "jane_eyre_dvd"}], "is not there (it is in bin_A)"),
        ([{"bin": "bin_A", "item": "dove_beauty_bar"}], "is not there (it is in no bin)"),
        ([{"bin": "bin_A", "item": "crayola_24_ct", "count": 2}], "count: unknown key; known: bin, item"),
    ],
)  # fmt: skip
def test_one_mistake_in_a_work_order_is_one_problem(work_order: Any, problem: str) -> None:
    message = refusal(pick_data(bin_A=["crayola_24_ct", "jane_eyre_dvd"]) | {"work_order": work_order})
    assert problem in message
    assert len(message.splitlines()) == 1


def test_a_target_from_a_bin_that_is_missing_is_not_there() -> None:
    data = pick_data(bin_A=["jane_eyre_dvd"])
    del data["bin_contents"]["bin_A"]
    message = refusal(data)
    assert "the bin 'bin_A' is missing; add it (\"bin_A\": [] if empty)" in message
    assert "is ordered from bin_A but is not there (it is in no bin)" in message


@pytest.mark.parametrize(
    ("data", "problems"),
    [
        (7, ["o.json:1:1: expected an object {...}, got 7"]),
        ({"tote_contents": []}, ["bin_contents: expected an object with"]),
        (pick_data() | {"bin_contents": []}, ["bin_contents: expected an object with a list of items"]),
        (pick_data() | {"tote_contents": "soap"}, ['tote_contents: expected a list of items, got "soap"']),
        (pick_data(bin_B=[None]), ["bin_contents.bin_B[0]: expected text in quotes, got null"]),
        (pick_data() | {"work_orders": []}, ["work_orders: unknown key; did you mean 'work_order'?"]),
    ],
)  # fmt: skip
def test_what_an_order_is_not_is_said_once(data: Any, problems: list[str]) -> None:
    lines = refusal(data).splitlines()
    assert len(lines) == len(problems)
    for line, problem in zip(lines, problems, strict=True):
        assert problem in line


def test_only_keys_that_do_not_stand_yet_are_suggested() -> None:
    data = pick_data()
    data["bin_contents"]["bin_AB"] = data["bin_contents"].pop("bin_B")
    assert "bin_AB: unknown bin; did you mean 'bin_B'?" in refusal(data)


def test_bin_contents_alone_are_no_order() -> None:
    lines = refusal({"bin_contents": pick_data()["bin_contents"]}).splitlines()
    assert len(lines) == 1 and lines[0].startswith("o.json:1:1: neither 'work_order' nor 'tote_contents'")


def test_a_value_of_any_length_is_told_short() -> None:
    assert len(refusal(pick_data() | {"tote_contents": "x" * 100_000})) < 200


def test_what_is_no_order_has_no_name_of_one() -> None:
    names = order_names()
    assert "kth_2015_example" in names and not {"pr2_belt_static", "apple_commission"} & {*names}
