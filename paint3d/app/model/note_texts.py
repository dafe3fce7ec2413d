"""What a reader tells of a mesh, in the user's language; see `files.readers.raw_mesh.RawMesh`."""

from __future__ import annotations

import re

__all__ = ["note_in_chinese"]

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
