"""Tufts of single hairs in the studio: undo, images, sessions and recovery keep every hair."""

import dataclasses

import numpy as np
import pytest

from paint3d.app.model.brush_in_hand import scaled
from paint3d.app.model.commands import decode_command, encode_command
from paint3d.app.model.document import Document
from paint3d.app.model.input.symmetry import MirrorPlane, Symmetry
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, recoverable
from paint3d.app.model.stroke_log import recording_of
from paint3d.app.model.stroke_painter import ImagePainter
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BristleSpec
from paint3d.cli.main import main
from paint3d.errors import BrushError, SessionError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session, save_session
from paint3d.painter.painter import Painter
from paint3d.recording.recording import save_recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.hands import line, paint, same_vertices, small_plane

HAIRY = dataclasses.replace(load_brush("full"), name="hairy", bristles=BristleSpec(n_hairs=40))


def hairy_plane(**options):
    return small_plane(brush=HAIRY, **options)


def hairs_of(document):
    kept = document.painter.hairs.keep()
    return kept["load"], kept["memory"]


def test_undo_brings_every_hair_back():
    document = hairy_plane()
    seen = []
    for y in (-10, 10):
        seen.append((*hairs_of(document), document.painter.ledger()))
        paint(document, (-20, y), (20, y))
    for load, memory, ledger in reversed(seen):
        document.undo()
        np.testing.assert_array_equal(hairs_of(document)[0], load)
        np.testing.assert_array_equal(hairs_of(document)[1], memory)
        assert document.painter.ledger() == ledger
    assert not document.surface.painted.any()


def test_images_have_hairs_of_their_own():
    document = hairy_plane()
    document.surface.refine_all()
    document.set_symmetry(Symmetry((MirrorPlane((0, 0, 0), (0, 1, 0)),)))
    paint(document, (-20, 30), (20, 30))
    alone = hairy_plane()
    alone.surface.refine_all()
    paint(alone, (-20, 30), (20, 30))
    np.testing.assert_array_equal(hairs_of(document)[0], hairs_of(alone)[0])
    accounts = document.painter.ledger()
    loaded = accounts.pop("loaded")
    assert sum(accounts.values()) == pytest.approx(loaded, rel=1e-6)
    y = document.surface.paint_mesh.vertices[:, 1]
    inked = document.surface.amounts[:, 0] * document.surface.vertex_areas
    assert inked[y < 0].sum() == pytest.approx(inked[y > 0].sum(), rel=0.1)


def test_a_session_keeps_every_hair(tmp_path):
    document = hairy_plane()
    paint(document, (-20, 0), (20, 0))
    document.save(tmp_path / "a.p3d")
    again = Document.open(tmp_path / "a.p3d")
    assert again.painter.brush == HAIRY
    assert again.strokes[0].brush == HAIRY
    for one, two in zip(hairs_of(document), hairs_of(again), strict=True):
        np.testing.assert_array_equal(one, two)
    for each in (document, again):
        paint(each, (-20, 9), (20, 9))
    same_vertices(again.surface, document.surface)
    again.properties["hairs"] = None
    for bad in ({}, {"load": [[1.0]], "memory": []}, {"load": 5, "memory": 5}):
        again.painter.hairs.keep = lambda bad=bad: {k: np.array(v) for k, v in bad.items()}
        again.save(tmp_path / "b.p3d")
        with pytest.raises(SessionError, match="hairs"):
            Document.open(tmp_path / "b.p3d")


@pytest.mark.parametrize("tools", [["--brush", "feibai"], ["--hairs", "30"], ["--hairs", "0"]])
def test_a_session_by_command_opens_with_its_hairs(tmp_path, tools):
    """The tuft is the one that painted, and every hair holds what it held."""
    file, out = tmp_path / "a.jsonl", tmp_path / "a.p3d"
    samples = line((-15, 0), (15, 0))
    recording = recording_of(samples, {"brush": "feibai", "ink": "pine soot"})
    save_recording(recording, file)
    on = ["--on", "plane", "--resolution", "3", "--quiet"]
    assert main(["replay", str(file), *on, *tools, "--out", str(out)]) == 0
    document = Document.open(out)
    alone = Painter(
        PaintedSurface(load_mesh("plane"), 3.0), "feibai",
        hairs=None if tools[0] == "--brush" else int(tools[1]),
    )  # fmt: skip
    alone.replay(recording)
    assert (document.painter.hairs is None) == (alone.hairs is None)
    if alone.hairs is not None:
        assert document.painter.hairs.spec == alone.hairs.spec
        np.testing.assert_array_equal(document.painter.hairs.load, alone.hairs.load)
        np.testing.assert_array_equal(document.painter.hairs.memory, alone.hairs.memory)


def test_a_session_by_an_older_command_opens(tmp_path):
    """It said which hairs there are, not what each holds."""
    document = hairy_plane()
    paint(document, (-20, 0), (20, 0))
    document.save(tmp_path / "a.p3d")
    session = load_session(tmp_path / "a.p3d")
    told = {**session.settings, "hairs": dataclasses.asdict(HAIRY.bristles)}
    save_session(dataclasses.replace(session, settings=told, history=None), tmp_path / "b.p3d")
    again = Document.open(tmp_path / "b.p3d")
    paint(again, (-20, 9), (20, 9))
    assert again.painter.hairs.total().sum() > 0.0


def test_a_session_from_before_tufts_could_split_opens(tmp_path):
    document = hairy_plane()
    paint(document, (-20, 0), (20, 0))
    load, memory = hairs_of(document)
    document.painter.hairs.keep = lambda: {"load": load, "memory": memory[:-1]}
    document.save(tmp_path / "a.p3d")
    again = Document.open(tmp_path / "a.p3d")
    np.testing.assert_array_equal(hairs_of(again)[1], np.append(memory[:-1], 0.0))
    again.undo()
    again.redo()
    np.testing.assert_array_equal(hairs_of(again)[0], load)


def test_a_kill_gives_every_hair_back(tmp_path):
    document = hairy_plane()
    paint_thread = PaintThread(document, recovery=RecoveryFolder(document, tmp_path))
    for y in (-10, 0, 10):
        paint_thread.post("begin_stroke")
        paint_thread.feed(line((-20, y), (20, y)))
        paint_thread.set_autosave_interval(0.001 if y == 0 else 600.0)
        paint_thread.post("end_stroke").result(timeout=300)
        with paint_thread.paused():  # a base is kept after the second, before the third is begun
            paint_thread.set_autosave_interval(600.0)
    paint_thread.stop(keep=True)
    (unfinished,) = recoverable(tmp_path)
    assert [base.name for base in unfinished.folder.glob("base*")] == ["base-2.p3d"]
    again = unfinished.recover().document
    same_vertices(again.surface, document.surface)
    np.testing.assert_array_equal(hairs_of(again)[0], hairs_of(document)[0])


def test_a_hairy_brush_is_scaled_and_written_down():
    large = scaled(HAIRY, 1.5)
    assert large.bristles == HAIRY.bristles
    document = small_plane()
    line = encode_command(document, "set_brush", [large], {})
    assert decode_command(line, document.surface)[2] == {"brush": large}
    document.set_brush(dataclasses.asdict(large))
    assert document.painter.brush == large
    with pytest.raises(BrushError, match="no brush"):
        document.set_brush({"name": "x"})


def test_an_image_that_fails_leaves_the_hands_ink_to_the_hand():
    document = small_plane()
    image = ImagePainter(document.painter, np.diag([1.0, -1.0, 1.0, 1.0]))
    load = document.surface.ink.load
    load *= 0.5  # the hand has painted; the image's brush still holds all
    held = load.copy()

    def fail() -> None:
        raise RuntimeError("no")

    with pytest.raises(RuntimeError, match="no"):
        image.lift(fail)
    np.testing.assert_array_equal(document.surface.ink.load, held)
