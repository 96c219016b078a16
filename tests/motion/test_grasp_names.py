"""The name of a grasp in a reason is found again."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.motion.plan import GraspKind

KINDS = st.from_regex(r"[a-z]+(-[a-z]+)?", fullmatch=True)
FACES = st.from_regex(r"[+-]?[a-z]+", fullmatch=True)


@given(kind=KINDS, face=FACES)
def test_a_name_is_found_in_front_of_anything_else(kind: str, face: str) -> None:
    grasp = GraspKind(kind, face)
    assert GraspKind.named_in(str(grasp)) == grasp
    assert GraspKind.named_in(f"arm left, {grasp}, lift: collision") == grasp


@pytest.mark.parametrize("text", ["", "segment 3 (lift)", "the grasp on faces", "soap, face +z"])
def test_other_texts_name_no_grasp(text: str) -> None:
    assert GraspKind.named_in(text) is None
