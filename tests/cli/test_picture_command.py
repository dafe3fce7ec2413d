"""`paint3d picture`: what a person gets, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from paint3d.cli import main, picture
from paint3d.files.export import export
from paint3d.files.project.session import Session, save_session
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording, save_recording
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.shot import AUTO, FLAT, UNLIT, VIEWS
from paint3d.view.studio import LIGHTS
from tests.support.app.hands import paint, small_plane
from tests.support.surface_cases import flat, poses, sheet
from tests.view.test_view_picture import needs_opengl


def stroke(y: float, ink: str) -> Recording:
    points = np.stack([np.linspace(-8.0, 8.0, 30), np.full(30, y), np.zeros(30)], axis=1)
    held = poses(points, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), np.full(30, 0.5), "slender")
    return replace(held, header={"brush": "slender", "ink": ink})


@pytest.fixture(scope="module")
def saved(tmp_path_factory) -> Path:
    """A sheet with a stroke of cinnabar: a session, a mesh and a recording of it."""
    folder = tmp_path_factory.mktemp("painting")
    surface = PaintedSurface(sheet(flat, (40.0, 20.0), 2.0), resolution=0.5, material="xuan")
    recording = stroke(-8.0, "cinnabar")
    Painter(surface, "slender", "cinnabar").replay(recording)
    save_session(Session(surface, (recording,)), folder / "a.p3d")
    export(surface, folder / "a.ply")
    save_recording(recording, folder / "a.jsonl")
    return folder


def run(*words: object) -> int:
    return main.main(["picture", *map(str, words), "--quiet"])


def test_the_choices_are_those_of_the_view() -> None:
    assert set(picture.VIEWS) == {AUTO, FLAT, *VIEWS}  # known to the command before NumPy is
    assert set(picture.LIGHTS) == {UNLIT, *LIGHTS}


@needs_opengl
@pytest.mark.usefixtures("few_pixels")
@pytest.mark.parametrize(("name", "size"), [("a.p3d", None), ("a.ply", (400, 200))])
def test_a_flat_picture_of_a_session_or_a_mesh(saved: Path, tmp_path: Path, name, size) -> None:
    out = tmp_path / "flat.png"
    asked = () if size is None else ("--pixels", "x".join(map(str, size)))
    assert run(saved / name, "--out", out, "--view", "flat", *asked) == 0
    with Image.open(out) as image:
        assert image.size == (size or (566, 283))
        pixels = np.asarray(image)
    red = (pixels[..., 0] > 1.5 * pixels[..., 1].astype(float)).mean()
    assert 0.01 < red < 0.3  # cinnabar


@needs_opengl
def test_a_film_and_a_picture_on_nothing(saved: Path, tmp_path: Path) -> None:
    film, still = tmp_path / "a.webp", tmp_path / "b.webp"
    words = ("--light", "none", "--pixels", "48x32")
    assert run(saved / "a.ply", "--out", film, "--turn", "1", "--fps", "5", *words) == 0
    with Image.open(film) as image:
        assert (image.n_frames, image.size) == (5, (48, 32))
    assert run(saved / "a.ply", "--out", still, "--transparent", "--view", "30,40", *words) == 0
    with Image.open(still) as image:
        assert (getattr(image, "n_frames", 1), image.mode) == (1, "RGBA")
    assert run(saved / "a.ply", "--out", tmp_path / "a.gif", "--fps", "1", *words) == 0
    with Image.open(tmp_path / "a.gif") as image:
        assert image.n_frames == 4


def test_outlines_of_a_recording_and_of_a_session_are_the_same(saved: Path, tmp_path: Path) -> None:
    for name in ("a.jsonl", "a.p3d"):
        assert run(saved / name, "--out", tmp_path / f"{name}.svg") == 0
    one, two = ((tmp_path / f"{name}.svg").read_bytes() for name in ("a.jsonl", "a.p3d"))
    assert one == two
    root = ElementTree.fromstring(one)
    groups = root.findall("{*}g")
    assert [len(group.findall("{*}path")) for group in groups] == [1]
    assert float(root.get("width").removesuffix("mm")) > 16.0


def test_outlines_of_strokes_by_hand_are_of_the_brush_that_painted_them(tmp_path: Path) -> None:
    widths = []
    for length in (35.0, 17.5):  # the presets know no brush of the second name
        document = small_plane()
        document.resize_brush(length)
        paint(document, (-20, 0), (20, 0), height=length)
        document.save(tmp_path / f"{length}.p3d")
        assert run(tmp_path / f"{length}.p3d", "--out", tmp_path / "a.svg", "--force") == 0
        root = ElementTree.parse(tmp_path / "a.svg").getroot()
        widths.append(float(root.get("height").removesuffix("mm")))
    assert widths[1] < 0.7 * widths[0]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("a.ply", "--out", "a.jpg"), "unknown kind of file; expected a name ending in .png"),
        (("no.ply", "--out", "a.png"), "no such file"),
        (("a.jsonl", "--out", "a.png"), "a.jsonl is a recording; expected a painting, or --out"),
        (("a.ply", "--out", "a.svg"), "a.ply holds no strokes; expected a recording, or a session"),
        (("a.ply", "--out", "a.png", "--view", "5"), "'5' is not a view; expected one of auto"),
        (("a.ply", "--out", "a.png", "--pixels", "9x9"), "'9x9' is not a size; expected WxH"),
        (("a.ply", "--out", "a.png", "--zoom", "0"), "zoom is 0; expected 0.1 to 20"),
        (("a.ply", "--out", "a.png", "--turn", "3"), "a film is wanted"),
        (("a.ply", "--out", "a.gif", "--turn", "9999"), "is not a time; expected 0.1 to 120"),
        (("a.ply", "--out", "a.gif", "--fps", "0"), "'0' is not a rate; expected 1 to 60"),
        (("a.ply", "--out", "a.gif", "--transparent"), "a .gif has no soft edges to nothing"),
        (("a.ply", "--out", "a.webp", "--turn", "100", "--fps", "50", "--pixels", "999x999"),
         "5000 pictures of 999 x 999 pixels are too many"),
        (("a.ply", "--out", "a.ply"), "unknown kind of file"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(saved: Path, monkeypatch, capsys, words, told) -> None:
    monkeypatch.chdir(saved)
    before = sorted(saved.iterdir())
    assert run(*words) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert told in err
    assert sorted(saved.iterdir()) == before
