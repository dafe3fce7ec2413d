"""Laws of recordings: files keep them, and damage is always named."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from paint3d.errors import RecordingError
from paint3d.recording.recording import Recording, load_recording, save_recording

LAW = settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
ARRAYS = ("time_ns", "position", "orientation", "buttons", "object_position", "object_orientation")


@st.composite
def recordings(draw, space=("world", "pad")):
    n = draw(st.integers(1, 6))
    steps = draw(hnp.arrays(np.int64, n, elements=st.integers(1, 10**12)))
    far = st.floats(-1e6, 1e6)

    def turns():
        q = draw(hnp.arrays(np.float64, (n, 4), elements=st.floats(-1, 1)))
        q[:, 0] += 1.5 * np.where(q[:, 0] < 0, -1.0, 1.0)
        return q / np.linalg.norm(q, axis=1, keepdims=True)

    pressure = hnp.arrays(np.float64, n, elements=st.floats(0, 1))
    return Recording(
        np.cumsum(steps) + draw(st.integers(-(10**15), 10**15)),
        draw(hnp.arrays(np.float64, (n, 3), elements=far)),
        turns(),
        draw(st.none() | pressure),
        draw(hnp.arrays(np.int32, n, elements=st.integers(0, 2**31 - 1))),
        draw(hnp.arrays(np.float64, (n, 3), elements=far)),
        turns(),
        {"space": draw(st.sampled_from(space)), "ink": draw(st.text(max_size=8))},
    )


@LAW
@given(recording=recordings(), suffix=st.sampled_from([".jsonl", ".jsonl.gz", ".csv", ".csv.gz"]))
def test_a_file_keeps_every_number(recording, suffix, tmp_path):
    path = tmp_path / f"a{suffix}"
    save_recording(recording, path)
    again = load_recording(path)
    for name in ARRAYS:
        assert np.array_equal(getattr(again, name), getattr(recording, name)), name
    assert (again.pressure is None) == (recording.pressure is None)
    if recording.pressure is not None:
        assert np.array_equal(again.pressure, recording.pressure)
    assert again.header == recording.header
    before = path.read_bytes()
    save_recording(again, path)
    assert path.read_bytes() == before


@LAW
@given(recording=recordings(space=("pad",)))
def test_inkml_keeps_what_touches(recording, tmp_path):
    path = tmp_path / "a.inkml"
    down = recording.pressure is None or (recording.pressure > 0)
    if not np.any(down):
        with pytest.raises(RecordingError, match="never touches"):
            save_recording(recording, path)
        return
    save_recording(recording, path)
    again = load_recording(path)
    touching = again.pressure > 0
    kept = np.broadcast_to(down, len(recording))
    assert np.array_equal(again.position[touching], recording.position[kept])
    times = (recording.time_ns - recording.time_ns[0])[kept]
    assert again.time_ns[touching] == pytest.approx(times, abs=1)
    same = np.abs(np.sum(again.orientation[touching] * recording.orientation[kept], axis=1))
    assert same == pytest.approx(1.0, abs=1e-9)


def damaged(whole):
    """Truncations, and every byte replaced by one that matters, in turn."""
    for i in range(len(whole)):
        others = (0x00, 0xFF, 0x0A, ord("9"), ord("-"), ord("e"), ord('"'), whole[i] ^ 1)
        yield whole[:i] + bytes([others[i % len(others)]]) + whole[i + 1 :]
        if i % 3 == 0:
            yield whole[:i]


@pytest.mark.parametrize("suffix", [".jsonl", ".jsonl.gz", ".csv", ".inkml"])
def test_damage_is_named_or_harmless(tmp_path, suffix):
    recording = Recording(
        np.arange(2) * 1000,
        np.arange(6.0).reshape(2, 3),
        np.tile([0.6, 0.0, 0.8, 0.0], (2, 1)),
        np.array([0.25, 0.5]),
        header={"space": "pad"},
    )
    path = tmp_path / f"a{suffix}"
    save_recording(recording, path)
    words = set()
    for data in damaged(path.read_bytes()):
        path.write_bytes(data)
        try:
            found = load_recording(path)
        except RecordingError as error:
            words.add(str(error))
        else:
            assert (np.diff(found.time_ns) > 0).all()
            assert np.isfinite(found.position).all()
    assert all(text.startswith(f"a{suffix}:") for text in words)
    assert len(words) >= (3 if suffix.endswith(".gz") else 30)
