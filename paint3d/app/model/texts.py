"""What model and window say, in English and Chinese (data/texts.json); errors and notes in Chinese.

What only the window says stands in `app.window.wording`.
"""

from __future__ import annotations

import functools
import importlib.resources
import json
import os
import re
from collections.abc import Mapping

from paint3d.errors import UnknownNameError

__all__ = [
    "LANGUAGES",
    "PATTERNS",
    "Texts",
    "in_chinese",
    "load_texts",
    "note_in_chinese",
    "system_language",
]

LANGUAGES = ("en", "zh")


@functools.lru_cache(maxsize=1)
def load_texts() -> dict[str, dict[str, str]]:
    """All texts: by key, then by language."""
    file = importlib.resources.files("paint3d.app.model").joinpath("data/texts.json")
    result: dict[str, dict[str, str]] = json.loads(file.read_text("utf-8"))
    return result


def system_language(environment: Mapping[str, str] | None = None) -> str:
    """The language of the user's system, as far as it is one of `LANGUAGES`; else English."""
    environment = os.environ if environment is None else environment
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        value = environment.get(name, "").split(":")[0].split(".")[0].lower()
        if value:
            return value[:2] if value[:2] in LANGUAGES else "en"
    return "en"


class Texts:
    """What the interface says in one language.

    Parameters
    ----------
    language : {"system", "en", "zh"}

    Raises
    ------
    UnknownNameError
        For another language.

    Examples
    --------
    >>> Texts("en")("device.lost", count=3)
    '3 lost'
    """

    def __init__(self, language: str = "system") -> None:
        if language == "system":
            language = system_language()
        if language not in LANGUAGES:
            raise UnknownNameError("language", str(language), LANGUAGES)
        self.language = language

    def __call__(self, key: str, **values: object) -> str:
        """The text of a key, with values put in.

        Raises
        ------
        UnknownNameError
            If there is no such key.
        KeyError
            If a value that the text names is not given.
        """
        texts = load_texts()
        if key not in texts:
            raise UnknownNameError("text", str(key), texts)
        return texts[key][self.language].format(**values)


# ---- Errors --------------------------------------------------------------------------------------
# What goes wrong, in the user's language: our own errors are written in English.
#
# The program's errors name what, where and what was expected, in English, for whoever calls it from
# Python as well. The window says the commonest of them in Chinese, by their pattern; one not known
# keeps its English behind a Chinese word, so nothing is lost.


_REASONS = {
    "No space left on device": "磁盘已满",
    "Permission denied": "没有权限",
    "Read-only file system": "磁盘为只读",
    "No such file or directory": "没有这个文件或文件夹",
    "Is a directory": "这是一个文件夹",
    "Not a directory": "路径中有一段不是文件夹",
    "File name too long": "文件名太长",
    "Input/output error": "读写出错",
}

PATTERNS: tuple[tuple[str, str], ...] = (
    (r"(?P<a>.*) was asked for during a stroke; expected its end first", "请先写完这一笔"),
    (r"stroke (?P<a>\d+) of the history; expected (?P<b>\d+) to (?P<c>\d+)",
     "历史中没有第 {a} 笔，应在 {b} 到 {c} 之间"),
    (r"(?P<p>.*): (?:there is )?no such file; expected .*", "{p}：没有这个文件"),
    (r"(?P<p>.*): it is a folder; expected a mesh file", "{p}：这是文件夹，需要网格文件"),
    (r"(?P<p>.*): it is a link that leads nowhere; .*", "{p}：这是失效的链接，需要网格文件"),
    (r"(?P<p>.*): it is no plain file; expected .*", "{p}：这不是普通文件"),
    (r"(?P<p>.*): it does not fit into memory", "{p}：内存不够"),
    (r"(?P<p>.*): its structure is damaged near (?P<a>.*)", "{p}：文件已损坏，在 {a} 附近"),
    (r"(?P<p>.*): it is incomplete near (?P<a>.*)", "{p}：文件不完整，在 {a} 附近"),
    (r"(?P<p>.*): it cannot be used: (?P<a>.*)", "{p}：无法使用：{a}"),
    (r"(?P<p>.*): it has no vertices and no triangles; expected a surface", "{p}：里面没有表面"),
    (r"(?P<p>.*): it has (?P<a>[\d,]+) points but no triangles; expected a surface",
     "{p}：只有 {a} 个点，没有三角形"),
    (r"(?P<p>.*): (?P<a>\S+) is no suffix .*", "{p}：不认识后缀 {a}"),
    (r"(?P<p>.*): .*; expected one of (?P<a>.*)", "{p}：不支持这种格式，可用：{a}"),
    (r"(?P<p>.*): the folder (?P<a>.*) does not exist", "{p}：文件夹 {a} 不存在"),
    (r"(?P<p>.*): cannot write here: (?P<r>.*)", "{p}：无法写入此处：{r}"),
    (r"(?P<p>.*): cannot write: (?P<r>.*)", "{p}：无法写入：{r}"),
    (r"(?P<p>.*): cannot be made: (?P<r>.*)", "{p}：无法建立：{r}"),
    (r"(?P<p>.*): cannot (?:be read|read it): (?P<r>.*)", "{p}：无法读取：{r}"),
    (r"(?P<p>.*): cannot keep what is painted here: (?P<r>.*)", "{p}：无法在此保留恢复数据：{r}"),
    (r"(?P<p>.*): it is no text that glTF could be: .*", "{p}：不是 glTF 文件"),
    (r"(?P<p>.*): its JSON (?P<a>.*)", "{p}：不是可用的 glTF 文件"),
    (r"brush length \(mm\) is (?P<a>\S+); expected (?P<b>.*)", "笔头长 {a} 毫米不可用"),
    (r"vertex (?P<a>\d+); expected 0 to (?P<b>\d+)", "没有第 {a} 个顶点，应在 0 到 {b} 之间"),
    (r"(?P<p>.*): another window has taken it up; expected .*", "{p}：另一个窗口已经接手"),
    (r"(?P<p>.*): is gone, and its pigments with it", "{p}：文件已不在，其中的颜料也没有了"),
    (r"(?P<p>.*): has changed; its pigments are as it says now",
     "{p}：文件已改动，颜料按现在的内容"),
    (r"the cut lies at the stroke's end; expected .*", "分处在笔画的端头，应在两端之间"),
    (r"the cut parts nothing; expected .*", "此处分不开，应在笔画的墨迹之内"),
    (r"a stroke was to be joined to itself; expected .*", "不能与自身合笔，请选另一笔"),
    (r"a stroke without area was to be joined; expected .*", "这一笔没有墨迹，不能合笔"),
    (r"(?P<p>.*): it is a folder; expected a photograph", "{p}：这是文件夹，需要照片"),
    (r"(?P<p>.*): no picture that can be read \(.*\)", "{p}：不是能读的图片"),
    (r"(?P<p>.*): another picture than the strokes were found in; .*",
     "{p}：不是当初寻找笔画的那张照片"),
    (r"(?P<p>.*): not named as a picture; expected a photograph", "{p}：不是图片的文件名"),
    (r"the strokes lie beside the sheet; expected them on it", "笔画不在纸上"),
    (r"corners are .*; expected places in it", "四角应在照片之内"),
    (r"corners are .*; expected four, one after another .*", "四角应依次绕纸一周"),
    (r"(?P<p>.*): (?P<a>[a-z]+ (?:'.*'|\d+)): (?P<b>[a-z0-9-]+) (?:is|has) (?P<c>['\"].*['\"]); "
     "expected .*",
     "{p}：{a} 的 {b} 中 {c} 不可用"),
    (r"the ink lies in (?P<a>[\d,]+) dots and gaps of a few pixels, .*",
     "墨迹是 {a} 个网点，请用灰度扫描"),
    (r"the ink lies in (?P<a>[\d,]+) pieces .*", "墨迹有 {a} 块，太多了，请裁剪照片"),
    (r"there are more than (?P<a>[\d,]+) strokes on the sheet; .*",
     "纸上的笔画超过 {a} 笔，请裁剪照片"),
    (r"(?P<p>.*) has no glyph for (?P<a>.*); (?P<b>.*) of the system would do",
     "{p} 没有这些字形：{a}；系统字体 {b} 有"),
    (r"(?P<p>.*) has no glyph for (?P<a>.*); try another font",
     "{p} 没有这些字形：{a}；请换一种字体"),
    (r"some of the ink is in no stroke: character (?P<a>.*); compare .*",
     "部分墨迹未归入笔画：字 {a}；请与照片对照"),
    (r"dish (?P<a>\d+) is empty; expected ink in it", "墨碟 {a} 是空的"),
)  # fmt: skip
"""English, as a pattern, and the Chinese that says the same; r is a system's reason."""


def in_chinese(message: str) -> str:
    """An error's message in Chinese; one that is not known keeps its English."""
    text = " ".join(message.split())
    for pattern, chinese in PATTERNS:
        found = re.fullmatch(pattern, text)
        if found is not None:
            values = found.groupdict()
            if "r" in values:
                values["r"] = _reason(values["r"])
            return chinese.format(**values)
    return f"未能完成：{text}"


def _reason(english: str) -> str:
    for known, chinese in _REASONS.items():
        if known in english:
            return chinese
    return english


# ---- Notes ---------------------------------------------------------------------------------------
# What a reader tells of a mesh, in the user's language; see `files.raw_mesh.RawMesh`.


_WHOSE = {"vertex colours": "顶点颜色", "colours of faces": "面颜色"}
_COLOURS = "(?P<w>vertex colours|colours of faces)"

_NOTES: tuple[tuple[str, str], ...] = (
    (f"left out: its {_COLOURS}, none of which is a number", "未采用：{w}（全都不是数）"),
    (rf"left out: its {_COLOURS}, most of which are not within 0 to (?P<end>[\d,]+)",
     "未采用：{w}（大多不在 0 到 {end} 之间）"),
    (r"left out (?P<n>[\d,]+) faces that name a vertex twice", "去掉了 {n} 个重复用同一顶点的面"),
    (r"a texture is left out: (?P<c>.*)", "未采用一张贴图：{c}"),
    (r"materials are left out: (?P<c>.*)", "未采用材质：{c}"),
    (rf"(?P<n>[\d,]+)(?: of (?P<m>[\d,]+))? {_COLOURS} are no numbers: made white",
     "{n} 处{w}不是数，已改为白色"),
    (rf"its {_COLOURS} are taken as 0 to (?P<end>[\d,]+)", "{w}按 0 到 {end} 读取"),
    (rf"(?P<n>[\d,]+) of (?P<m>[\d,]+) {_COLOURS} are not within 0 to (?P<end>[\d,]+): "
     "brought to the nearest that is", "{m} 处{w}中有 {n} 处不在 0 到 {end} 之间，已取最近的值"),
    (r"it is a point cloud: built (?P<n>[\d,]+) triangles through (?P<m>[\d,]+) points",
     "这是点云：由 {m} 个点构成 {n} 个三角形"),
    (r"its Gaussian splats are taken as points", "高斯泼溅按点读取"),
    (r"left out: its polypaint, of (?P<n>[\d,]+) vertices instead of (?P<m>[\d,]+)",
     "未采用：顶点绘色（有 {n} 个顶点，网格有 {m} 个）"),
    (r"its header's line (?P<a>.*) is passed over", "文件头中的 {a} 一行未采用"),
)  # fmt: skip
"""English, as a pattern, and the Chinese that says the same; c is a cause, w whose colours."""

_CAUSES: tuple[tuple[str, str], ...] = (
    (r"it refers to (?P<a>.*), which is missing", "找不到 {a}"),
    (r"it refers to (?P<a>.*) outside its folder, which is not followed", "{a} 不在同一文件夹内"),
    (r"it refers to (?P<a>.*), which is no file name", "{a} 不是文件名"),
    (r"its texture is no picture that can be read: .*", "图片无法读取"),
    (r"its texture has (?P<a>.*) pixels; expected (?P<b>.*)", "图片有 {a} 像素，最多 {b}"),
    (r"it is larger than (?P<a>.*) bytes; expected less", "超过 {a} 字节"),
    (r"the file is empty", "文件是空的"),
    (r"it names no picture in (?P<a>.*)", "{a} 中没有图片名"),
    (r"the mesh has no places on it", "网格没有贴图坐标"),
    (r"the mesh has no (?P<a>TEXCOORD_\d+)", "网格没有 {a}"),
)
"""The same for why something was left out."""


def note_in_chinese(note: str) -> str | None:
    """A reader's note in Chinese; None for one that is a list of words, or is not known."""
    return _translated(note, _NOTES)


def _translated(text: str, table: tuple[tuple[str, str], ...]) -> str | None:
    for pattern, chinese in table:
        found = re.fullmatch(pattern, text)
        if found is not None:
            values = found.groupdict()
            if "c" in values:
                values["c"] = _translated(values["c"], _CAUSES) or values["c"]
            if "w" in values:
                values["w"] = _WHOSE[values["w"]]
            return chinese.format(**values)
    return None
