"""What the window says: one catalogue has all of it, and errors bring what they say with them."""

from __future__ import annotations

import pickle
import re

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtWidgets

from paint3d import errors
from paint3d.app.model.commands import COMMANDS, SHORTCUTS, TITLES
from paint3d.app.window.wording import (
    LANGUAGES,
    choose_language,
    say,
    say_brush,
    say_error,
    say_material,
    say_object,
    say_units,
    system_language,
)
from paint3d.brush.presets import brush_names, load_brush
from paint3d.calligraphy.processes import in_processes
from paint3d.colour.materials import load_materials
from paint3d.core.atomic import write_atomically
from paint3d.errors import (
    ExportError,
    InputError,
    LayerError,
    MeshError,
    Message,
    Paint3DError,
    UnknownNameError,
)
from paint3d.files.load import BUILT_IN_OBJECTS
from paint3d.files.reading import AS_IT_IS, read_surface, read_surface_apart
from tests.support.app.gestures import answer
from tests.support.app.windows import opened
from tools.texts import CATALOGUES, Text, faults_of, find_texts, update


@pytest.fixture(scope="module")
def texts():
    """All that is said, looked for once, by the one process that asks."""
    return find_texts()


@pytest.fixture
def chinese():
    choose_language("zh")
    yield
    choose_language("en")


# ---- The catalogues ------------------------------------------------------------------------------


@pytest.mark.parametrize("catalogue", CATALOGUES, ids=lambda path: path.parts[-3])
def test_a_catalogue_has_all_that_is_said_with_the_same_fields_and_nothing_else(
    catalogue, texts
) -> None:
    assert faults_of(catalogue, texts) == []


def test_what_is_wrong_with_a_catalogue_is_told(tmp_path) -> None:
    file = tmp_path / "paint3d.po"
    file.write_text(
        'msgid ""\nmsgstr "Content-Type: text/plain; charset=UTF-8\\n"\n\n'
        'msgid "{n} left"\nmsgstr "剩 {m}"\n\nmsgid "gone"\nmsgstr "没了"\n',
        encoding="utf-8",
    )
    texts = {Text("{n} left", ""): ["a.py"], Text("{n} face", "{n} faces"): ["b.py"]}
    told = "\n".join(faults_of(file, texts))
    assert told.count("\n") == 2
    assert all(word in told for word in ("'{n} face'", "'gone'", "剩 {m}"))
    update(file, texts)
    assert [*faults_of(file, texts)] == [line for line in told.split("\n") if "gone" not in line]


def test_no_text_asks_a_painter_to_type_commands(texts) -> None:
    typed = re.compile(r"(?<![\w-])--[a-z]|\b(pip|npm|apt) |paint3d [a-z]+ ")
    assert [text.text for text in texts if typed.search(text.text)] == []


@pytest.mark.parametrize("code", LANGUAGES)
def test_all_names_are_said(code) -> None:
    choose_language(code)
    try:
        said = [say_object(name) for name in BUILT_IN_OBJECTS]
        said += [say_material(material) for material in load_materials().values()]
        said += [*say_units().values(), *(say(TITLES[one.group]) for one in SHORTCUTS)]
        said += [say(one.text) for one in COMMANDS.values() if one.menu or one.drag]
        brushes = [say_brush(name) for name in brush_names()]
    finally:
        choose_language("en")
    assert all(said)
    assert len(set(brushes)) == len(brushes)
    is_chinese = [bool(re.search("[\u4e00-\u9fff]", one)) for one in said + brushes]
    assert all(is_chinese) if code == "zh" else not any(is_chinese)


@pytest.mark.parametrize(
    ("environment", "language"),
    [
        ({}, "en"),
        ({"LANG": "zh_CN.UTF-8"}, "zh"),
        ({"LANG": "zh_CN.UTF-8", "LC_ALL": "C"}, "en"),
        ({"LANGUAGE": "zh:en", "LANG": "en_US"}, "zh"),
        ({"LANG": "de_DE"}, "en"),
    ],
)
def test_the_system_s_language_is_found(environment, language) -> None:
    assert system_language(environment) == language


def test_a_language_without_a_catalogue_is_refused() -> None:
    with pytest.raises(UnknownNameError):
        choose_language("de")


# ---- Messages ------------------------------------------------------------------------------------


def test_a_text_is_said_with_its_fields(chinese) -> None:
    assert say("{count} lost", count=3) == "丢失 3"
    assert say("{n} picture", "{n} pictures", n=3) == "共 3 帧"
    assert say("") == ""


def test_english_has_a_plural() -> None:
    assert [say("{n} picture", "{n} pictures", n=n) for n in (1, 2)] == ["1 picture", "2 pictures"]


def test_messages_are_said_with_what_they_quote(chinese) -> None:
    what = Message("{one}, {other}", one=Message("animations"), other=Message("lines"))
    assert say(Message("left out: {what}", what=what)) == "未采用：动画、线条"
    cause = MeshError("the file is empty")
    note = Message("a texture is left out: {cause}", cause=cause)
    assert (str(note), say(note)) == (
        "a texture is left out: the file is empty",
        "未采用一张贴图：文件是空的",
    )


def test_what_is_a_user_s_own_stays_as_it_is(chinese) -> None:
    assert say("{name} is saved in {path}", name="Close", path="{n}") == "Close 已存入 {n}"
    assert say_brush("Close") == "Close"


def test_an_error_of_a_child_process_keeps_its_fields(chinese) -> None:
    with pytest.raises(UnknownNameError) as found:
        list(in_processes(load_brush, ["ful"], 1))
    assert found.value.message.fields["near"] == "full"
    assert say_error(found.value).startswith("没有毛笔“ful”：是“full”吗？")


def test_what_a_reader_in_a_child_process_says_keeps_its_fields(tmp_path, chinese) -> None:
    broken, odd = tmp_path / "broken.stl", tmp_path / "odd.obj"
    broken.write_bytes(b"solid")
    odd.write_text("mtllib gone.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n")
    told = []
    for read in (read_surface, read_surface_apart):
        with pytest.raises(MeshError) as found:
            read(broken, AS_IT_IS)
        notes = read(odd, AS_IT_IS._replace(texture=True)).notes
        told.append((found.value.message.to_json(), [note.to_json() for note in notes]))
    assert told[0] == told[1]
    assert told[0][0]["fields"]["file"] == str(broken)
    assert [say(Message.from_json(words)) for words in told[0][1]] == [
        "未采用材质：找不到 'gone.mtl'",
        "未采用：线条",
    ]


@pytest.mark.parametrize(
    "error",
    [
        *(getattr(errors, name)("{n} of it", n=3) for name in errors.__all__
          if name.endswith("Error") and name not in ("UnknownNameError", "LayerError")),
        LayerError("“{layer}” is locked", layer=Message("Layer {number}", number=1)),
        UnknownNameError("brush", "{n}", ["a"]),
        ExportError("{file}: {cause}", file="{a}", cause=OSError(28, "No space left on device")),
    ],
)  # fmt: skip
def test_errors_and_messages_can_be_packed(error) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again), again.hint) == (type(error), str(error), error.hint)
    assert again.message.to_json() == error.message.to_json()
    assert Message.from_json(again.message.to_json()).to_json() == error.message.to_json()


def test_an_error_takes_over_the_message_and_the_hint_of_another() -> None:
    cause = MeshError("{n} points", n=3, hint="--from-points")
    for error in (InputError(cause), InputError("{file}: {cause}", file="a", cause=cause)):
        assert error.hint == "--from-points"
        assert str(error) == f"{error.message} (--from-points)"
    assert InputError(cause).message.fields == {"n": 3}


def test_the_system_s_reason_is_said(tmp_path, chinese) -> None:
    with (
        pytest.raises(Paint3DError) as found,
        write_atomically(tmp_path / "none" / "a.ply") as part,
    ):
        part.write_bytes(b"")
    assert say_error(found.value) == f"{tmp_path}/none/a.ply：无法写入此处：没有这个文件或文件夹"


def test_a_chinese_window_says_in_chinese_what_went_wrong(program, tmp_path, chinese) -> None:
    broken = tmp_path / "broken.ply"
    broken.write_text("ply\nformat ascii 1.0\nelement vertex 9\n")
    told = []

    def read(box: QtWidgets.QMessageBox) -> None:
        told.append(box.text())
        box.accept()

    with opened(program) as window:
        window.workspace.quiet = False
        answer(read, QtWidgets.QMessageBox)
        assert not window.opening.open_path(str(broken))
    assert told == [f"{broken}：文件头没有结尾；应有 end_header 一行"]
