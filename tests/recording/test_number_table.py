"""Tables of numbers, read by blocks: what is in them and which line is wrong, and little memory."""

from __future__ import annotations

import io
import random
import struct
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from paint3d.errors import RecordingError
from paint3d.recording import number_table, recording
from paint3d.recording.number_table import NumberTable
from paint3d.recording.recording import TextLines, load_recording


def read(lines: list[str], delimiter: str | None = ",") -> NumberTable:
    table = NumberTable(["time_ns", "x", "z"], "a.csv", {"time_ns"}, {"z"})

    def split(line: str) -> list[str] | None:
        row = line.strip()
        return [cell.strip().strip('"') for cell in row.split(delimiter)] if row else None

    text = TextLines(io.BytesIO("\n".join(["the names", *lines]).encode()), "a.csv")
    next(text)
    table.read(text, delimiter, split)
    return table


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "_BLOCK", 40)
    monkeypatch.setattr(number_table, "_FEWEST", 2)
    monkeypatch.setattr(number_table, "_MOST", 7)


@pytest.mark.usefixtures("small_blocks")
def test_every_way_to_write_a_number_gives_what_python_reads() -> None:
    rng = random.Random(5)
    ways = ["{}", " {}", "{} ", '"{}"', "\t{}", "+{}"]
    floats = ["0.1", "1e-3", "7", "1_0.5", ".5", "5.", "123456789.123456789", "2.5E2", "1e18"]
    ints = ["0", "9007199254740993", "12", "1_000", "4611686018427387903"]
    rows = [(rng.choice(ints), rng.choice(floats), rng.choice([*floats, ""])) for _ in range(200)]
    table = read([",".join(rng.choice(ways).format(c) if c else c for c in row) for row in rows])
    assert len(table) == 200
    _, times = table.column("time_ns")
    assert times.dtype == np.int64
    assert times.tolist() == [int(row[0]) for row in rows]
    assert table.column("none", "x")[1].tolist() == [float(row[1]) for row in rows]
    z = table.column("z")[1]
    np.testing.assert_array_equal(z, [float(row[2] or "nan") for row in rows])
    assert [table.line(k) for k in (0, 3, 199)] == [2, 5, 201]
    table.let_go("x", "none")
    assert table.column("x") is None


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1,nan,2", "x is 'nan'; expected a finite number"),
        ("1,inf,2", "x is 'inf'; expected a finite number"),
        ("1,1e19,2", "x is '1e19'; expected a finite number"),
        ("1.0,1,2", "time_ns is '1.0'; expected an integer"),
        ("1e3,1,2", "time_ns is '1e3'; expected an integer"),
        ("99999999999999999999,1,2", "expected an integer"),
        ("4611686018427387904,1,2", "expected an integer"),
        ("1,,2", "x is ''; expected a finite number"),
        ("1,0x10,2", "x is '0x10'; expected a finite number"),
        ("1,1", "there are 2 columns; expected 3"),
        ("1,1,1,1", "there are 4 columns; expected 3"),
        ("1,1,1 # so", "z is '1 # so'; expected a finite number"),
    ],
)
def test_the_line_that_is_wrong_is_named(row: str, words: str) -> None:
    lines = [f"{k},1,2" for k in range(7)]
    with pytest.raises(RecordingError) as caught:
        read([*lines, row, *lines])
    assert str(caught.value).startswith("a.csv:9: ")
    assert words in str(caught.value)


def some_numbers(n: int) -> list[str]:
    """Decimals of all kinds, and some half-way between two floats, or a trifle beside that."""
    rng = random.Random(11)
    found = []
    while len(found) < n:
        value = abs(struct.unpack("<d", rng.randbytes(8))[0])
        if not 1e-9 < value < 1e15:
            value = 10.0 ** rng.uniform(-8.0, 15.0)
        found += [repr(value), f"{value:.{rng.randrange(12)}f}", f"{value:.{rng.randrange(17)}e}"]
        whole = rng.randrange(2**53, 2**54) | 1  # an odd one lies between two
        for trifle in (-1, 0, 1):
            found.append(f"{whole * 10 + trifle}e-1")
            found.append(f"{whole * 5**3 * 10 ** (19 - len(str(whole * 125))) + trifle}e-22")
    return found


def test_the_nearest_float_of_every_decimal_is_read() -> None:
    texts = some_numbers(3_000)
    table = read([f"{k},{text},1" for k, text in enumerate(texts)])
    assert table.column("x")[1].tolist() == [float(text) for text in texts]


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_empty_cells_and_lines_are_known_in_plain_blocks(end: str) -> None:
    """They are read by blocks: a large recording has them in every row."""
    rows = ["1,2,3", "", "2,-.5e1,", " ", "3, 4 ,", '"4","5",6']
    table = NumberTable(["time_ns", "x", "z"], "a.csv", {"time_ns"}, {"z"})
    text = TextLines(io.BytesIO(end.join(rows).encode()), "a.csv")
    table.read(text, ",", lambda line: pytest.fail("row by row"))
    assert table.column("time_ns")[1].tolist() == [1, 2, 3, 4]
    np.testing.assert_array_equal(table.column("z")[1], [3.0, np.nan, np.nan, 6.0])
    assert [table.line(k) for k in range(4)] == [1, 3, 5, 6]


def test_a_row_of_no_numbers_takes_no_room_for_its_columns() -> None:
    names = [f"c{k}" for k in range(9_000)]
    table = NumberTable(names, "a.csv")
    text = TextLines(io.BytesIO(b"\n" * 50_000 + b"1"), "a.csv")
    tracemalloc.start()
    try:
        with pytest.raises(RecordingError, match=r"a\.csv:50001: there are 1 columns"):
            table.read(text, ",", lambda line: line.split(",") if line.strip() else None)
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()


def test_a_large_pad_takes_little_more_than_its_numbers(tmp_path: Path) -> None:
    n = 150_000
    rows = [f"{k // 5000},{k},{k % 97}.25,{k % 89}.5,0.25" for k in range(n)]
    file = tmp_path / "pad.csv"
    file.write_text("stroke,time_ms,x_mm,y_mm,pressure\n" + "\n".join(rows))
    del rows
    tracemalloc.start()
    try:
        recording = load_recording(file)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(recording) == n + 2 * 29
    assert peak < 120 * n, peak / n
    for name in ("orientation", "object_position", "object_orientation"):
        assert getattr(recording, name).strides[0] == 0, name
    with pytest.raises(ValueError, match="read-only"):
        recording.orientation[0] = 1.0
