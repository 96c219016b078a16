"""Seeds follow from names alone, and differ where the names do."""

from __future__ import annotations

import numpy as np

from pickcli.seeds import derived_rng, derived_seed


def test_derived_seeds_tell_their_parts_apart() -> None:
    seeds = {
        derived_seed("a", 1, "bc"),
        derived_seed("a", 1, "b", "c"),
        derived_seed("a1", "bc"),
        derived_seed(),
    }
    assert len(seeds) == 4
    assert all(1 <= seed < 2**31 for seed in seeds)


def test_a_generator_is_that_of_its_names() -> None:
    np.testing.assert_array_equal(derived_rng("a", 1).random(4), derived_rng("a", 1).random(4))
    assert derived_rng("a", 1).random() != derived_rng("a", 2).random()
