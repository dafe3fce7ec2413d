"""Which blocks of a wet surface are moved together, and how alike their steps are."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.surface.kernels.wet_graph import grade_paces, group_blocks

SIDE = 6


def lattice():
    """Blocks of a square: the run of each one's neighbours, and these."""
    n = SIDE * SIDE
    row, column = np.divmod(np.arange(n), SIDE)
    near = (np.abs(row[:, None] - row) <= 1) & (np.abs(column[:, None] - column) <= 1)
    np.fill_diagonal(near, False)
    last = np.cumsum(near.sum(axis=1))
    return near, last - near.sum(axis=1), last, np.nonzero(near)[1].astype(np.int32)


def some_blocks():
    return st.sets(st.integers(0, SIDE * SIDE - 1), min_size=1).map(
        lambda blocks: np.array(sorted(blocks), np.int64)
    )


@settings(max_examples=60, deadline=None)
@given(some_blocks())
def test_no_block_lies_next_to_two_groups(blocks):
    near, first, last, beside = lattice()
    head, group = np.full(SIDE * SIDE, -1, np.int32), np.empty(len(blocks), np.int32)
    count = group_blocks(blocks, first, last, beside, head, group)
    assert (head == -1).all()
    reach = near | np.eye(SIDE * SIDE, dtype=bool)
    meets = (reach[blocks].astype(int) @ reach[:, blocks].astype(int)) > 0
    for _ in range(SIDE * SIDE):  # whoever meets through others meets
        meets = (meets.astype(int) @ meets.astype(int)) > 0
    np.testing.assert_array_equal(group[:, None] == group, meets)
    assert sorted(set(group.tolist())) == list(range(count))
    assert group[0] == 0


@settings(max_examples=60, deadline=None)
@given(some_blocks(), st.sampled_from([1.01, 1.15, 2.0]), st.integers(0, 2**31))
def test_steps_differ_little_from_block_to_block(wet, most, seed):
    near, first, last, beside = lattice()
    pace = np.full(SIDE * SIDE, np.inf, np.float32)
    pace[wet] = np.exp(np.random.default_rng(seed).uniform(-3, 3, len(wet)))
    before = pace.copy()
    grade_paces(wet, first, last, beside, most, pace)
    assert (pace <= before).all()
    assert pace.min() == before.min()
    both = near[np.ix_(wet, wet)]
    quotient = pace[wet][:, None] / pace[wet]
    assert quotient[both].max(initial=0.0) <= most * (1 + 1e-6)
