"""The Chinese of what the window says, by its English."""

from __future__ import annotations

__all__ = ["CHINESE"]

CHINESE = {
    "Show the brush": "显示毛笔", "Save the strokes as a recording…": "将笔画存为录制…",
    "Refine the whole surface now": "立即细分整个表面", "Dark theme": "深色界面", "Tools": "工具",
    "Hand": "手", "Absorbency": "吸水", "Grain": "粗糙", "Glaze": "釉",
    "Tuft": "笔头", "Water": "水", "Dip": "蘸墨", "Empty": "倒空", "Rinse": "洗笔",
    "Only the tip": "只蘸笔尖", "Export…": "导出…",
    "Drag points; click to add one, right button to take one away":
        "拖动各点；单击添一点，右键去一点",
    "New layer": "新图层", "Remove layer": "删除图层", "Move up": "上移", "Move down": "下移",
    "Hide": "隐藏", "Show": "显示", "Lock": "锁定", "Unlock": "解锁", "undone": "已撤销",
    "Strokes: {n}, {seconds:.1f} s": "{n} 笔，{seconds:.1f} 秒",
    "{hair}, {length:g} mm long, {width:g} mm thick":
        "{hair}，长 {length:g} 毫米，粗 {width:g} 毫米",
    "full": "满毫", "slender": "细长", "calibrated": "标定", "xiaokai": "小楷", "zhongkai": "中楷",
    "dakai": "大楷", "gongbi": "工笔", "baiyun": "白云", "xiaobaiyun": "小白云",
    "zhongbaiyun": "中白云", "dabaiyun": "大白云",
    "Paint with the left button or a pen; turn with Alt or the middle button":
        "左键或压感笔作画；按 Alt 或中键转动",
    "This pen gives no times of its own; they are evened out": "这支笔不报时间，已按间隔均匀处理",
    "feibai": "飞白",
    "Grips on the picture": "画面上的握柄", "Show the mask": "显示遮罩",
    "Open an object, or drop a file here": "打开一件器物，或把文件拖到这里",
    "ink {share:.0f} %": "含墨 {share:.0f}%", "behind by {ms:.0f} ms": "落后 {ms:.0f} 毫秒",
    "keeps up, {ms:.1f} ms": "跟手，{ms:.1f} 毫秒", "Painting": "作画", "has caught up": "已跟上",
    "{fps:.0f} pictures/s": "每秒 {fps:.0f} 帧", "Stopped": "已停止",
    "The language changes with the next start": "下次启动时换用此语言",
    "Please wait": "请稍候", "Writing {name}…": "正在写出 {name}…",
    "Drawing the film…": "正在绘制影片…", "Refining the surface…": "正在细分表面…",
    "Paint is taken in {n} regions": "只在 {n} 个区域着墨",
    "Object": "器物", "A mesh file…": "网格文件…", "Begin": "开始",
    "Objects and paintings": "器物与作品", "Recordings": "录制", "All files": "所有文件",
    "Paintings": "作品", "Picture": "图片", "Film": "影片",
    "Brought back; save it to keep it": "已找回；请保存", "Everything": "所有格式",
    "Replace": "替换", "Quality": "质量", "Unit": "单位", "Up": "朝上的轴", "Colours": "颜色",
    "In proportion": "锁定比例", "As on the screen": "与屏幕所见相同", "Size in pixels": "像素尺寸",
    "The painted side, in the studio's light": "着墨一面，棚拍光线",
    "As the format has it": "按格式惯例", "At the vertices": "记在顶点上",
    "As a texture": "做成贴图",
    "As a texture of {n} pixels": "做成 {n} 像素的贴图", "Colours may miss by": "允许色差",
    "Every vertex, none left out": "保留全部顶点",
    "Colours as they are, without light": "颜色如实，不受光照",
    "Normals in one number": "法线压成一个数",
    "Few colours, one for each triangle": "限制颜色数，每个三角形一色", "How many": "颜色数",
    "glTF, for the web and most programs": "glTF，适合网页与多数软件", "PLY": "PLY 网格",
    "Wavefront OBJ": "OBJ 网格", "3MF, for printers": "3MF，适合打印",
    "USDZ, for Apple's devices": "USDZ，适合苹果设备",
    "VRML, for colour printers": "VRML，适合彩色打印", "Page that shows the object": "展示用网页",
    "Picture, PNG": "图片，PNG", "Picture, JPEG": "图片，JPEG",
    "Records of the vertices": "顶点记录",
    "Copy of the painting": "作品副本", "Recording, JSON Lines": "录制，JSON Lines",
    "Recording, JSON Lines, packed": "录制，JSON Lines，压缩", "Recording, InkML": "录制，InkML",
    "Film, WebP": "影片，WebP", "Film, GIF": "影片，GIF", "Length": "时长",
    "Pictures a second": "每秒帧数", "{n} pictures": "共 {n} 帧",
    "{n} pictures: too many of this size": "共 {n} 帧：按此尺寸太多",
    "Bring back what was not saved: {name}": "找回未保存的：{name}",
    "Lengths are shown in": "长度单位", "As the material asks for": "随材质而定",
    "Always": "总是", "Never": "从不",
    "Keep a whole copy for recovery every": "每隔多久留存完整副本",
    "Memory for undo, from the next painting on": "撤销所用内存（下一作品起）",
    "There is no stroke to replay": "没有可重放的笔画", "Stop": "停止",
    "Painting {n} strokes again, to go back to them…": "正在重画 {n} 笔，以便退回…",
    "{n} strokes were painted again; drying between them is not repeated":
        "已重画 {n} 笔；其间的变干不再重现",
    "Its undo steps cannot be used: {why}": "其撤销步骤无法使用：{why}",
    "Paint calligraphy on objects with a brush that bends, spreads and runs dry as a real one "
    "does.":
        "用一支会弯、会散、会干的笔，在器物上写字作画。",
}  # fmt: skip
