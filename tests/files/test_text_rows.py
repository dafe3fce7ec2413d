"""Numbers as text: read back by Python's own parser as the same numbers, in few characters."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.files.formats.text_rows import CHUNK, text_rows

floats = st.floats(-(2.0**49), 2.0**49, width=32)


def written(*args, **kwargs):
    return b"".join(text_rows(*args, **kwargs)).decode("ascii")


@settings(deadline=None, max_examples=200)
@given(st.lists(floats, min_size=1, max_size=20))
def test_a_float_reads_back_exactly(values):
    column = np.array(values, np.float32)[:, None]
    back = [np.float32(float(word)) for word in written("{f0}\n", column).split()]
    np.testing.assert_array_equal(back, column[:, 0])


def test_floats_of_every_size_read_back_exactly():
    bits = np.random.default_rng(3).integers(0, 1 << 32, 50_000, dtype=np.uint32)
    column = bits.view(np.float32)
    column = column[np.isfinite(column) & (np.abs(column) < 1e15)][:, None]
    words = written("{f0}\n", column).split()
    np.testing.assert_array_equal(np.array(words, np.float64).astype(np.float32), column[:, 0])


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1"),
        (-12.5, "-12.5"),
        (0.1, "0.1"),
        (1e-4, "1e-4"),
        (-2.5e-7, "-25e-8"),
        (1.4e-45, "14013e-49"),
        (100.0, "100"),
        (16777216.0, "16777216"),
    ],
)
def test_no_digit_too_many(value, text):
    assert written("{f0}", np.float32([[value]])) == text


def test_rows_have_text_and_numbers_in_any_order():
    table, ids = np.float32([[1, 2.5], [3, -4]]), np.int32([[10, 0], [2147483647, 7]])
    assert written("<{i1}|{f1}|{i0}|{f0}>", table, ids) == "<0|2.5|10|1><7|-4|2147483647|3>"
    assert written("x\n", integers=ids) == "x\nx\n"
    assert written("{f0}", np.empty((0, 1), np.float32)) == ""


def test_long_tables_come_in_parts():
    ids = np.arange(CHUNK + 5)[:, None]
    parts = list(text_rows("{i0}\n", integers=ids))
    assert len(parts) == 2
    assert b"".join(parts).split() == [b"%d" % k for k in range(CHUNK + 5)]
