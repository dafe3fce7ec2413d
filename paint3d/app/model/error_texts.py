"""What goes wrong, in the user's language: our own errors are written in English.

The program's errors name what, where and what was expected, in English, for whoever calls it from
Python as well. The window says the commonest of them in Chinese, by their pattern; one not known
keeps its English behind a Chinese word, so nothing is lost.
"""

from __future__ import annotations

import re

__all__ = ["PATTERNS", "in_chinese"]

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
