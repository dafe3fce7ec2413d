"""The papers' timing study: planned, measured from files, and tested in pairs."""

import json
import re
from collections import Counter
from xml.etree import ElementTree

import numpy as np
import pytest

from paint3d.app.model.studies.plan import StudyPlan, Trial, load_plan, make_plan, save_plan
from paint3d.app.model.studies.study import Measured, StudyTable, evaluate, find_file, measure
from paint3d.cli.main import main
from paint3d.cli.study import table_lines
from paint3d.device.recorded import Recording
from paint3d.errors import InputError
from paint3d.recording.recording import save_recording
from paint3d.recording.score import save_score
from tests.support.app.hands import UPRIGHT, paint, small_plane


def test_the_defaults_are_the_papers():
    plan = make_plan()
    assert (plan.character, plan.object, len(plan.participants)) == ("目", "bowl", 6)
    assert Counter(plan.order) == {("I", "II"): 3, ("II", "I"): 3}
    assert make_plan(seed=1).order != make_plan(seed=2).order
    assert make_plan(seed=1) == make_plan(seed=1)


@pytest.mark.parametrize("n", [2, 3, 4, 5])
def test_every_device_set_comes_in_every_place_and_after_every_other_equally_often(n):
    devices = [f"d{k}" for k in range(n)]
    plan = make_plan(n * 2, devices)
    for place in range(n):
        assert set(Counter(row[place] for row in plan.order).values()) == {2}
    after = Counter((row[i], row[i + 1]) for row in plan.order for i in range(n - 1))
    assert len(after) == n * (n - 1)
    assert set(after.values()) == {2}


def test_a_plan_is_kept_and_never_written_over(tmp_path):
    plan = make_plan(3, trials=2)
    save_plan(plan, tmp_path / "new")
    assert load_plan(tmp_path / "new") == plan
    with pytest.raises(InputError, match="there is a study"):
        save_plan(plan, tmp_path / "new")
    assert [t.stem for t in plan.schedule()][:2] == [
        f"P01-{plan.order[0][0]}-1", f"P01-{plan.order[0][0]}-2"
    ]  # fmt: skip


@pytest.mark.parametrize(
    "changes",
    [
        {"character": "目目"}, {"character": " "}, {"em_mm": 0.0}, {"devices": ["I"]},
        {"devices": ["I", "I"]}, {"devices": ["I", "a/b"]}, {"order": [["I", "I"]]},
        {"trials": 0}, {"version": 2}, {"participants": []}, {"extra": 1}, {"order": 5},
    ],
)  # fmt: skip
def test_bad_plans_are_told(tmp_path, changes):
    file = save_plan(make_plan(1), tmp_path)
    file.write_text(json.dumps(json.loads(file.read_text()) | changes))
    with pytest.raises(InputError, match=r"study\.json"):
        load_plan(tmp_path)


def strokes_file(path, seconds, x=0.0):
    """Two strokes on the plane that take so long altogether, with a pause between."""
    quarter = int(seconds * 0.25e9)
    times = np.concatenate([np.linspace(0, quarter, 20), np.linspace(3 * quarter, 4 * quarter, 20)])
    at = np.zeros((40, 3))
    at[:, 0] = x + np.tile(np.linspace(-12, 12, 20), 2)
    at[:, 1], at[:, 2] = np.repeat([8.8, -8.8], 20), 32.0
    pressure = np.full(40, 0.25)
    pressure[[0, 19, 20, 39]] = 0.0
    header = {"brush": "zhongbaiyun"}
    turned = np.tile(UPRIGHT, (40, 1))
    save_recording(Recording(times.astype(np.int64), at, turned, pressure, header=header), path)


@pytest.fixture
def folder(tmp_path):
    plan = make_plan(3, character="二", on="plane", em_mm=40.0)
    save_plan(plan, tmp_path)
    for k, participant in enumerate(plan.participants):
        strokes_file(tmp_path / f"{participant}-I-1.jsonl.gz", 8.0 + k)
        strokes_file(tmp_path / f"{participant}-II-1.csv", 4.0 + 0.6 * k)
    return tmp_path


def test_files_are_measured_and_compared(folder):
    table = evaluate(folder, load_plan(folder))
    assert (table.missing, table.faulty) == ((), ())
    mine = table.measured[0]
    assert mine.seconds == pytest.approx(8.0 if mine.trial.devices == "I" else 4.0, rel=1e-6)
    assert len(mine.stroke_seconds) == 2
    assert mine.pen_down_seconds == pytest.approx(0.5 * mine.seconds, rel=1e-6)
    assert 0.05 < mine.likeness < 0.9
    summary = table.summary("I", lambda m: m.seconds)
    assert (summary.n, summary.mean, summary.sd) == (3, pytest.approx(9.0), pytest.approx(1.0))
    (test,) = table.tests()
    assert test.ratio == pytest.approx(4.6 / 9.0)
    a, b = np.array([8.0, 9.0, 10.0]), np.array([4.0, 4.6, 5.2])
    by_hand = (a - b).mean() / ((a - b).std(ddof=1) / np.sqrt(3))
    assert test.t == pytest.approx(by_hand, rel=1e-4)
    assert 0.0 < test.p < 0.01 < test.wilcoxon_p


def test_a_saved_painting_is_measured(tmp_path):
    plan = make_plan(1, character="一", on="plane", em_mm=60.0)
    document = small_plane()
    for y in (0, 10):
        paint(document, (-20, y), (20, y), t0=1_000_000 + y * 10**9)
    document.save(tmp_path / "P01-I-1.p3d")
    strokes_file(tmp_path / "P01-I-1.csv", 5.0)  # the painting goes before the recording
    table = evaluate(tmp_path, plan, likeness=False)
    (mine,) = table.measured
    assert mine.file == "P01-I-1.p3d"
    assert mine.seconds == pytest.approx(10.095)
    assert mine.stroke_seconds == pytest.approx((0.095, 0.095))
    assert mine.likeness is None
    assert table.missing == ("P01-II-1",)


def test_strokes_of_two_sittings_are_put_in_one_clock(tmp_path):
    document = small_plane()
    for k, t0 in enumerate((50 * 10**9, 10**9)):
        paint(document, (-20, 0), (20, 0), t0=t0)
        document.strokes[k].time_s = 1000.0 + 20.0 * k
    document.save(tmp_path / "P01-I-1.p3d")
    plan = make_plan(1, character="一", on="plane")
    (mine,) = evaluate(tmp_path, plan, likeness=False).measured
    assert mine.seconds == pytest.approx(20.095)


def test_what_is_missing_or_broken_does_not_stop_the_others(folder):
    (folder / "P02-I-1.jsonl.gz").unlink()
    (folder / "P03-II-1.csv").write_text("no recording")
    table = evaluate(folder, load_plan(folder), likeness=False)
    assert table.missing == ("P02-I-1",)
    assert [name for name, _ in table.faulty] == ["P03-II-1.csv"]
    (test,) = table.tests()
    assert test.n == 1
    assert np.isnan(test.p)
    lines = table_lines(table)
    assert any(line.startswith("missing: P02-I-1") for line in lines)
    assert any("P03-II-1.csv" in line for line in lines)


def test_nobody_painted_yet():
    plan = StudyPlan("目", "bowl", 30.0, ("I", "II"), ("P01",), 1, (("I", "II"),))
    lines = table_lines(StudyTable(plan, (), ("P01-I-1", "P01-II-1"), ()))
    assert lines[1].split() == ["I", "0", "-", "-", "-", "-"]


def test_equal_times_are_no_difference():
    plan = make_plan(2)
    measured = tuple(Measured(t, "x", 5.0, (2.0,), None) for t in plan.schedule())
    (test,) = StudyTable(plan, measured, (), ()).tests()
    assert test.ratio == 1.0
    assert np.isnan(test.p)


def test_the_command_plans_and_prints_the_table(tmp_path, capsys, folder):
    new = tmp_path / "study"
    assert main(["study", "plan", str(new), "--participants", "2", "--character", "永"]) == 0
    out = capsys.readouterr().out
    assert "永 on bowl" in out
    assert "P02-II-1.p3d" in out
    assert main(["study", "table", str(folder), "--json", str(tmp_path / "r.json"), "--quiet"]) == 0
    out = capsys.readouterr().out
    assert "II takes 0.51 of the time of I: paired t(2)" in out
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["devices"]["I"]["seconds"]["mean"] == pytest.approx(9.0)
    assert len(report["trials"]) == 6
    assert main(["study", "table", str(tmp_path / "none")]) == 2
    assert "expected the plan of a study" in capsys.readouterr().err
    assert main(["study", "plan", str(tmp_path / "new")]) == 0
    assert main(["study", "table", str(tmp_path / "new")]) == 2
    assert "there is no trial yet; expected P01-I" in capsys.readouterr().err
    assert main(["study", "plan", str(new), "--participants", "0"]) == 2


def test_a_session_goes_before_recordings(tmp_path):
    trial = Trial("P01", "I", 1)
    assert find_file(tmp_path, trial) is None
    for suffix in (".csv", ".jsonl", ".p3d"):
        (tmp_path / f"P01-I-1{suffix}").write_text("")
        assert find_file(tmp_path, trial).name.endswith(suffix)


def answered(folder, *words):
    return main(["study", "answer", str(folder), *words])


def test_answers_are_kept_counted_and_tested(folder, capsys):
    assert answered(folder, "P01", "--prefers", "I") == 0
    for name in ("P01", "P02", "P03"):  # who changes their mind counts once
        assert answered(folder, name, "--prefers", "II", "--comment", "<easier>") == 0
    table = evaluate(folder, load_plan(folder), likeness=False)
    assert table.preferences() == {"I": 0, "II": 3, "none": 0}
    assert table.preference_p() == pytest.approx(0.25)  # 2 / 2^3
    assert "preferred, of 3: I 0; II 3; none 0; sign test p = 0.25" in table_lines(table)
    assert table.to_json()["preferences"]["answers"]["P02"]["comment"] == "<easier>"
    for words, told in (
        (("P09", "--prefers", "I"), "unknown participant 'P09'"),
        (("P01", "--prefers", "III"), "unknown device set 'III'"),
    ):
        capsys.readouterr()
        assert answered(folder, *words) == 2
        assert told in capsys.readouterr().err
    (folder / "answers.json").write_text("{}")
    assert main(["study", "table", str(folder), "--no-likeness", "--quiet"]) == 2
    assert "answers.json: it cannot be used" in capsys.readouterr().err


def test_the_report_is_one_page_whose_boxes_are_where_the_times_are(folder, tmp_path, capsys):
    assert answered(folder, "P01", "--prefers", "II", "--comment", "<b>& easier") == 0
    out = tmp_path / "out" / "a.html"
    out.parent.mkdir()
    words = ["study", "report", str(folder), "--out", str(out), "--no-likeness", "--quiet"]
    assert main(words) == 0
    page = out.read_text("utf-8")
    assert "<b>" not in page
    assert "&lt;b&gt;&amp; easier" in page
    assert "http" not in page
    assert "src=" not in page
    table = evaluate(folder, load_plan(folder), likeness=False)
    times = [list(table.by_participant(d, lambda m: m.seconds).values()) for d in ("I", "II")]
    figure = ElementTree.fromstring(re.search(r"<svg.*?</svg>", page, re.S).group())
    ticks = [
        (float(t.text), float(t.get("y")) - 4) for t in figure.iter("text") if t.get("x") == "46"
    ]
    (low, y_low), (high, y_high) = ticks[0], ticks[-1]
    assert low == 0.0
    assert high >= max(map(max, times))
    boxes = [box for box in figure.iter("rect") if box.get("class") == "box"]
    assert len(boxes) == 2
    for box, own in zip(boxes, times, strict=True):
        top = float(box.get("y"))
        shown = [top + float(box.get("height")), top]
        wanted = np.percentile(own, [25, 75])
        np.testing.assert_allclose(shown, y_low + (y_high - y_low) * wanted / high, atol=0.6)
    points = list(figure.iter("circle"))
    assert len(points) == sum(map(len, times))
    assert main([*words[:4], str(folder / "study.json"), "--quiet"]) == 2


def test_a_score_is_measured_by_the_strokes_that_stay(tmp_path):
    document = small_plane(1.0)
    for y in (-5.0, 0.0, 5.0):
        paint(document, (-10.0, y), (10.0, y))
    document.undo()
    save_score(document.score, tmp_path / "P01-I-1.score.jsonl")
    trial = Trial("P01", "I", 1)
    file = find_file(tmp_path, trial)
    assert file is not None
    found = measure(file, trial, on="plane")
    assert len(found.stroke_seconds) == 2
    assert found.seconds >= found.pen_down_seconds > 0.0
    kept = [s.duration_s for s in document.strokes]
    assert found.pen_down_seconds == pytest.approx(sum(kept), rel=0.3)
