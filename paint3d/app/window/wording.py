"""What the window says, in the language that was chosen.

Texts that the studio's model knows too are looked up by key (`app.model.texts`). What only the
window says is written in English where it is said, which is its key in `CHINESE` below.
"""

from __future__ import annotations

import re
from typing import Any

from paint3d.app.model.texts import Texts, in_chinese, load_texts
from paint3d.brush.presets import brush_names
from paint3d.colour.materials import Material, load_materials
from paint3d.errors import GlyphError, LayerError
from paint3d.files.load import UNITS_MM

__all__ = [
    "CHINESE",
    "choose_language",
    "choose_unit",
    "language",
    "say",
    "say_brush",
    "say_error",
    "say_layer",
    "say_length",
    "say_material",
    "say_object",
]

# ---- Chinese -------------------------------------------------------------------------------------
# The Chinese of what the window says, by its English.


CHINESE = {
    "The home folder cannot be written: settings and recovery data are kept in {folder}":
        "没有可写的主目录：设置与恢复数据暂存于 {folder}",
    "Characters of the copybook": "字帖字形",
    "{characters} taken from the font {font}": "“{characters}”取自字体 {font}",
    "No form of {characters} is known: install a font that has one, such as Noto Serif CJK, or "
    "choose another font":
        "没有“{characters}”的字形：请安装含有它的字体（如 Noto Serif CJK），或另选字体",
    "Open a drawing, strokes or a photograph…": "打开图样、笔画或照片…",
    "Drawings, strokes and photographs": "图样、笔画与照片",
    "Press a seal…": "钤印…", "Lines of one width": "等宽线条", "Font": "字体",
    "A drawing instead of the text": "以图代文", "A drawing": "图样",
    "Red lines (zhuwen)": "朱文", "White lines (baiwen)": "白文", "Style": "印文",
    "Longer side": "长边", "The seal as it will be cut": "印文样子",
    "Seals": "印章", "Seal {n}": "印 {n}", "Press it in the ink in hand": "改用手中的墨色钤印",
    "Move, press anew or delete a seal by the right button": "右键可移动、改色或删除印章",
    "Pressing the seal anew…": "正在重新钤印…",
    "Seal {n} is changed; undo takes it back": "第 {n} 方印已改；可以撤销",
    "Folder of characters": "字形文件夹", "of hanzi-writer-data; empty: those that come along":
        "hanzi-writer-data 文件夹；空着则用自带字形",
    "OK": "确定", "Cutting the seal…": "正在刻印…",
    "Click where to press the seal; Esc cancels": "单击钤印之处；按 Esc 作罢",
    "No seal was pressed": "未钤印",
    "Seal pressed; {percent:.0f} % of it touched the surface": "已钤印，着印 {percent:.0f}%",
    "Turn and scale the object…": "转动、缩放器物…", "Begin anew": "重新开始",
    "Keep its own colours and pictures": "保留自带的颜色与贴图", "Turn round": "转身",
    "Tip forward": "前翻", "Tip aside": "侧翻", "likely": "可能", "{axis} up": "{axis} 朝上",
    "Click the side it should stand on": "单击要着地的一面",
    "A quarter turn about {axis}": "绕 {axis} 轴转四分之一圈",
    "The file says which way is up": "文件注明了哪边朝上",
    "This is how it stands now": "现在是这样放着",
    "It would stand like this. Is that right?": "它会这样放着，对吗？",
    "Which way is up? The file does not say": "哪边朝上？文件没有注明",
    "One unit of the file": "文件的一个单位", "Longest side": "最长边",
    "Left out: {what}": "未采用：{what}", ", ": "、", "; ": "；",
    "Turning the object starts a new painting on it, without the paint. You can save this one "
    "first.":
        "上面已有墨迹。转动后将重新开始，不带墨迹；可先保存现有作品。",
    "Another material starts a new painting, without the paint. You can save this one first.":
        "上面已有墨迹。换材质后将重新开始，不带墨迹；可先保存现有作品。",
    "From a file…": "从文件……", "Materials": "材质", "Friction": "摩擦",
    "What the surface is made of; files of your own can describe others":
        "表面的材质；可用自己的文件描述其他材质",
    "{axis} was taken as up; change it by Edit ▸ Turn and scale the object":
        "已取 {axis} 朝上；可用“编辑 ▸ 转动、缩放器物”更改",
    "Which way is up is uncertain; change it by Edit ▸ Turn and scale the object":
        "哪边朝上未能确定；可用“编辑 ▸ 转动、缩放器物”更改",
    "its pictures": "贴图", "mixtures of materials": "混合材质",
    "its colours and pictures": "颜色与贴图", "relief (a normal map)": "凹凸（法线贴图）",
    "relief (a bump map)": "凹凸（凹凸贴图）", "shadows baked into a picture": "烘焙的阴影",
    "light of its own": "自发光", "metal and gloss from a picture": "金属与光泽贴图",
    "how its ink shines": "墨的光泽",
    "gloss from a picture": "光泽贴图", "transparency": "透明", "displacement": "置换",
    "extensions of its materials": "材质扩展", "animations": "动画", "skins": "蒙皮",
    "morph targets": "变形目标", "lines": "线条", "points": "点", "lights": "灯光",
    "cameras": "相机", "curves": "曲线", "free-form surfaces": "自由曲面",
    "beam lattices": "梁格", "colours of faces": "面颜色",
    "colours painted in a slicer": "切片软件中涂的颜色", "numbers of colours": "颜色编号",
    "hidden parts": "隐藏的部分",
    "Show the brush": "显示毛笔", "Save the strokes as a recording…": "将笔画存为录制…",
    "Refine the whole surface now": "立即细分整个表面", "Dark theme": "深色界面", "Tools": "工具",
    "Hand": "手", "Absorbency": "吸水", "Grain": "粗糙", "Glaze": "釉",
    "Tuft": "笔头", "Water": "水", "Dip": "蘸墨", "Empty": "倒空", "Rinse": "洗笔",
    "Only the tip": "只蘸笔尖", "Export…": "导出…",
    "Drag points; click to add one, right-click to remove one":
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
    "This pen reports no times; its events are spaced evenly": "这支笔不报时间，已按间隔均匀处理",
    "This pen reports pressures outside 0 to 1; they are clipped":
        "这支笔报告的压力超出 0 到 1，已截取到此范围",
    "feibai": "飞白", "langhao": "狼毫", "yanghao": "羊毫", "jianhao": "兼毫",
    "Grips on the picture": "画面上的握柄", "Show the mask": "显示遮罩",
    "Still painting; try again in a moment": "仍在作画，请稍后再试",
    "Open an object, or drop a file here": "打开一件器物，或把文件拖到这里",
    "ink {share:.0f} %": "含墨 {share:.0f}%", "behind by {ms:.0f} ms": "落后 {ms:.0f} 毫秒",
    "keeps up, {ms:.1f} ms": "跟手，{ms:.1f} 毫秒", "Painting": "作画", "has caught up": "已跟上",
    "{fps:.0f} pictures/s": "每秒 {fps:.0f} 帧", "Stopped": "已停止",
    "The replay was stopped by your stroke": "您已落笔，重放停止",
    "The replay was stopped; undo takes back what it painted": "重放已停止；撤销可去掉所画的部分",
    "Film of the painting growing…": "作画过程影片…",
    "The replay was stopped": "重放已停止", "Pause": "暂停",
    "The replay was stopped and undone": "重放已停止并撤销",
    "Replaying; Esc stops it": "正在重放；按 Esc 停止",
    "The language changes with the next start": "下次启动时换用此语言",
    "Please wait": "请稍候", "Writing {name}…": "正在写出 {name}…",
    "Finishing the current step…": "正在完成当前这一步…",
    "Drawing the film…": "正在绘制影片…", "Refining the surface…": "正在细分表面…",
    "Regions that take paint: {n}": "着墨的区域：{n} 个", "Paint is taken everywhere": "处处着墨",
    "Object": "器物", "A mesh file…": "网格文件…", "Begin": "开始",
    "Sheets": "纸绢", "Objects": "器物", "Width": "宽", "Height": "高", "Margin": "留白",
    "Breadth": "扇面宽", "Across": "张开宽", "Diameter": "直径",
    "Mounted, with a border of silk": "装裱（绢边）",
    "Lay out a text…": "布字…", "Signature and date…": "落款…",
    "What the line says, beside the text": "落款写什么",
    "Drag it to its place; T ends": "拖到要放的地方；按 T 结束",
    "Drag a text to move it, its corner to scale it, the ring to turn it; arrows move, with Ctrl "
    "turn and scale, with Alt space; Esc ends":
        "拖动文字以移动，拖角缩放，拖圆点转动；方向键移动，加 Ctrl 转动缩放，"
        "加 Alt 调间距；按 Esc 结束",
    "There is no text there": "那里没有文字", "Laid out": "已布", "Another": "另布一段",
    "Lay it out beside the texts that are there": "不动已布的文字，另布一段",
    "Move on the object": "在器物上移动", "Drag, turn, scale and space texts; also by T":
        "拖动、转动、缩放文字并调间距；也可按 T",
    "Take away": "撤去", "Grid": "格子", "Apart": "行距字距", "Turned": "转角", "Moved by": "移动",
    "Squares": "方格", "Cross and diagonals (mi)": "米字格", "Nine fields (jiu)": "九宫格",
    "Cross (tian)": "田字格", "Lines between columns": "界行", "No grid": "无格",
    "Squares of a grid without a text": "无字时的格数：横、竖",
    "Room between columns, or rows, in parts of the size": "行与行之间，字径的百分比",
    "Room between characters, in parts of the size": "字与字之间，字径的百分比",
    "A line for each column or row; Ctrl+Enter lays it out": "一行字占一行；Ctrl+回车布字",
    "Grid of {across} × {down}": "{across} × {down} 格",
    "What is kept free by text that is laid out": "排字时四周留出的空白",
    "Objects and paintings": "器物与作品", "Recordings": "录制", "All files": "所有文件",
    "Paintings": "作品", "Picture": "图片", "Film": "影片",
    "Recovered; save it to keep it": "已找回；请保存", "Everything": "所有格式",
    "Folder": "文件夹", "File name": "文件名", "Format": "格式",
    "Replace": "替换", "Quality": "质量", "Unit": "单位", "Up": "朝上的轴", "Colours": "颜色",
    "In proportion": "锁定比例", "As on the screen": "与屏幕所见相同", "Size in pixels": "像素尺寸",
    "The painted side, in the studio's light": "着墨一面，棚拍光线",
    "As the format has it": "按格式惯例", "At the vertices": "记在顶点上",
    "As a texture": "做成贴图",
    "As a texture of {n} pixels": "做成 {n} 像素的贴图", "Colours may miss by": "允许色差",
    "Every vertex, none left out": "保留全部顶点",
    "Colours as they are, without light": "颜色如实，不受光照",
    "Normals in one number": "法线压成一个数", "Colours of a screen": "屏幕色域",
    "{n} colours do not fit in and are the nearest that do.": "{n} 处颜色超出色域，已取最近者。",
    "Few colours, one for each triangle": "限制颜色数，每个三角形一色", "How many": "颜色数",
    "glTF, for the web and most programs": "glTF，适合网页与多数软件", "PLY": "PLY 网格",
    "Wavefront OBJ": "OBJ 网格", "3MF, for printers": "3MF，适合打印",
    "USDZ, for Apple's devices": "USDZ，适合苹果设备",
    "Page that shows the object": "展示用网页",
    "Picture, PNG": "图片，PNG", "Picture, JPEG": "图片，JPEG",
    "Records of the vertices": "顶点记录",
    "Copy of the painting": "作品副本", "Recording, JSON Lines": "录制，JSON Lines",
    "Recording, JSON Lines, packed": "录制，JSON Lines，压缩", "Recording, InkML": "录制，InkML",
    "Whole painting, JSON Lines": "整幅作品，JSON Lines",
    "Whole painting, JSON Lines, packed": "整幅作品，JSON Lines，压缩",
    "Film, WebP": "影片，WebP", "Film, GIF": "影片，GIF", "Film, MP4": "影片，MP4",
    "Length": "时长",
    "Pictures a second": "每秒帧数", "{n} pictures": "共 {n} 帧",
    "{n} pictures: too many of this size": "共 {n} 帧：按此尺寸太多",
    "Recover unsaved work": "找回未保存的画",
    "Unsaved paintings stay in the menu: {where}": "未保存的画仍在菜单中：{where}",
    "Recover unsaved work: {name}": "找回未保存的：{name}",
    "Lengths are shown in": "长度单位", "As the material asks for": "随材质而定",
    "Always": "总是", "Never": "从不",
    "Keep a whole copy for recovery every": "每隔多久留存完整副本",
    "Memory for undo, from the next painting on": "撤销所用内存（下一作品起）",
    "There is no stroke to replay": "没有可重放的笔画", "Stop": "停止",
    "Repainting {n} strokes to go back to them…": "正在重画 {n} 笔，以便退回…",
    "{n} strokes were repainted; drying between them is not repeated":
        "已重画 {n} 笔；其间的变干不再重现",
    "Recovery data is being saved again": "恢复数据已重新开始保留",
    "{name} is open in another window, too": "{name} 也在另一个窗口中打开着",
    "{name} was saved by another window or program since it was opened here.":
        "{name} 在此打开之后，已被另一个窗口或程序保存过。",
    "Its undo steps cannot be used: {why}": "其撤销步骤无法使用：{why}",
    "Paint calligraphy on objects with a brush that bends, spreads and runs dry as a real one "
    "does.":
        "用一支会弯、会散、会干的笔，在器物上写字作画。",
    "Stylus that pushes back": "力反馈笔", "Reached by": "接入方式", "Pushes at most": "最大推力",
    "The first there is": "自动选择", "HID protocol of paint3d": "paint3d 的 HID 协议",
    "OpenHaptics (Touch, Phantom)": "OpenHaptics（Touch、Phantom）",
    "Haply Inverse3": "Haply Inverse3", "None": "无", "Sheet to touch, wide": "校准纸宽",
    "Felt before contact": "触前感知", "Click at a dip": "蘸墨轻叩",
    "Grain is felt": "手感颗粒",
    "and deep": "纸深", "Calibrate…": "校准…",
    "Touch the four corners of a sheet on the table": "依次点触桌上一张纸的四角",
    "Touch the {corner} corner and press the stylus' button": "点触{corner}角，并按笔上的键",
    "near left": "左下", "near right": "右下", "far right": "右上", "far left": "左上",
    "Calibrated: {mm:.2f} mm off": "已校准：误差 {mm:.2f} 毫米",
    "No stylus is there to calibrate": "没有可校准的笔",
    "Force feedback stopped: {why}": "笔不再有力反馈：{why}",
    "6-DOF mouse": "六自由度鼠标", "The cap is": "握帽即", "the object": "器物",
    "the viewer": "观者", "Moves": "移动", "Turns": "转动", "Dead zone": "死区",
    "Finer near rest": "近静止处更细", "It moves": "可移动", "It turns": "可转动",
    "One axis at a time": "一次只动一轴", "Comes near when": "拉近时",
    "the cap is pushed": "握帽前推", "the cap is lifted": "握帽上提", "Right by": "向右",
    "Away by": "向前", "Up by": "向上",
    "Turn about right by": "绕右轴转", "Turn about away by": "绕前轴转",
    "Turn about up by": "绕上轴转",
    "Button": "按钮", "does": "作用", "Nothing": "无作用", "Recentre": "回中",
    "Lock turning": "锁定转动", "Lock moving": "锁定移动", "Object or viewer": "器物或观者",
    "The cap rests here": "以此为静止",
    "Drag stroke {n} to its new place; Esc cancels":
        "把第 {n} 笔拖到要放的地方；按 Esc 放弃",
    "That is beside the object": "那里没有器物",
    "Move it on the object": "在器物上移动", "Move it by numbers…": "按数值移动…",
    "Paint it in the ink in hand": "改用手中的墨色",
    "Paint it with the brush in hand": "改用手中的笔",
    "Its time…": "时间…", "Delete it": "删除", "Edit": "编辑",
    "Edit the stroke that is chosen; also by the right button": "编辑选中的一笔；也可用右键",
    "There is no stroke to edit": "没有可编辑的笔画",
    "Move stroke {n}": "移动第 {n} 笔", "To the right (x)": "向右（x）", "Upwards (y)": "向上（y）",
    "Turn to the left": "向左转", "Move": "移动", "Time of stroke {n}": "第 {n} 笔的时间",
    "It takes": "历时", "It begins later by": "推迟", "Change": "更改",
    "Repainting what follows stroke {n}…": "正在重画第 {n} 笔之后的笔画…",
    "Stroke {n} edited; {after} after it repainted in {seconds:.1f} s; undo takes it back until "
    "the painting is closed":
        "第 {n} 笔：已改；其后 {after} 笔已重画，用时 {seconds:.1f} 秒；关闭此画之前可以撤销",
    "Mix a colour…": "调一种颜色…", "Open a table of pigments…": "打开颜料表…",
    "Tables of pigments": "颜料表", "Pigments": "颜料", "Pick-up": "沾回",
    "How much of the tuft is dipped, from the tip": "从笔尖起蘸多少",
    "Colour": "颜色", "Asked for": "所求", "A coat of it": "涂一层",
    "Into the mixing dish": "倒入调色碟", "Dip the brush": "蘸笔",
    "hardly to be seen": "几乎看不出差别", "seen side by side": "并排才看得出",
    "no mixture of these inks comes nearer": "这些墨色调不出更近的",
    "Burnt": "焦", "Thick": "浓", "Heavy": "重", "Light": "淡", "Clear": "清",
    "{tone}: {share:.0f} % ink, the rest water": "{tone}：墨 {share:.0f} %，其余是水",
    "Brush editor": "制笔", "Edit the brush…": "修改毛笔…", "Open a brush…": "打开毛笔文件…",
    "Edit…": "修改…", "Open…": "打开…", "Brushes": "毛笔", "Name": "名称", "Close": "关闭",
    "Force, spread, ink": "力、散、墨", "Hairs": "毛", "Dynamics": "动态", "by": "随",
    "Length L": "锋长 L", "Root": "根径", "Taper": "收锋", "Point": "笔尖",
    "Segments n": "段数 n", "Tip segment l1": "尖段 l1", "Stiffness exponent q": "刚度指数 q",
    "Hardness H": "硬度 H", "Full press": "按到底", "Greatest force": "最大力",
    "Friction μ": "摩擦 μ", "Spread by pressure b": "压力铺散 b",
    "Spread by friction c": "摩擦铺散 c", "Drag": "拖后", "Bend that stays": "留弯",
    "Ink in a full tuft": "满笔墨量", "Ink given per mm": "每毫米给墨",
    "Paint with single hairs": "用单根毛画", "Number of hairs": "毛数",
    "Thickness of a hair": "毛的粗细", "Leaves ink within": "触纸距离", "Film of ink": "墨膜",
    "Uneven lengths": "长短不齐", "Parting": "分岔", "Splay": "平铺", "Uneven giving": "出墨不匀",
    "Levelling": "匀墨", "Pressed out over": "压直",
    "Stiffness": "硬挺", "Spread": "铺散", "Ink given": "给墨", "Wetness": "湿润",
    "pressure": "压力", "tilt": "倾斜", "speed": "速度", "ink left": "余墨", "curvature": "曲率",
    "Bent by least energy": "按最小能量弯", "Bent as FastBrush measured": "按 FastBrush 实测弯",
    "Bent as measured, own table": "按自己的实测表弯",
    "Nothing drives this brush": "没有动态",
    "Footprints at {presses} of the force": "力为 {presses} 时的笔痕",
    "A stroke on xuan": "宣纸上的一笔",
    "Paint with it": "就用它画", "Save as mine": "存为我的笔",
    "{name} is saved in {path}": "{name} 已存入 {path}",
    "Choose one on the object": "在器物上选一笔",
    "Click a stroke on the object, or drag it to its new place; Esc cancels":
        "单击器物上的一笔，或把它拖到要放的地方；按 Esc 作罢",
    "There is no stroke there": "那里没有笔画",
    "Remove own pigments": "收起自备颜料",
    "Your own pigments are off the list; their files stay": "自备颜料已收起；文件仍在",
    "It touches": "已触到",
    "For a stylus without a button, by the other hand": "用于没有按钮的笔，由另一只手来按",
    "Tuft wet": "蘸湿", "Full": "饱满",
    "How much of the tuft a dip wets, from the tip": "一蘸从笔尖起湿多少",
    "How full that part becomes; 100 % as it is made": "蘸湿部分多饱满；100 % 为常态",
    "Dip automatically when less than a quarter is left": "余墨不足四分之一时自动蘸笔",
    "Dipped automatically: {percent:.0f} % was left": "已自动蘸笔：只剩 {percent:.0f} %",
    "Strokes over the picture…": "图上笔画…",
    "The corrections are kept; check the strokes again": "改动仍在：请再看一次图上笔画",
    "The strokes lie over their ink: {why}": "笔画衬以墨迹：{why}",
    "The strokes lie over the photograph {file}": "笔画衬以照片 {file}",
    "Order, direction and shape of the strokes of a font, a drawing or a photograph":
        "字体、图样或照片中各笔的笔顺、方向与形状",
    "Reverse": "反向", "Leave out": "不写", "Take in": "要写", "Earlier": "提前", "Later": "推后",
    "Join": "合笔", "Split": "分笔", "Undo": "撤销", "Redo": "重做",
    "Corners of the sheet": "纸的四角", "Save the strokes…": "保存笔画…",
    "Save the strokes": "保存笔画", "Strokes": "笔画", "Use": "使用",
    "As ghosts on the object": "作为器物上的范字", "The whole piece": "整个字",
    "Earlier, later and leave out take all strokes of its piece": "提前、推后与不写对整个字起作用",
    "Write the stroke the other way": "把这一笔反过来写",
    "It is no stroke, or is to be written again": "这不是笔画；或重新要写",
    "Write it before the one before": "写在前一笔之前",
    "Write it after the next one": "写在后一笔之后",
    "Make one stroke of this and another": "与另一笔合成一笔",
    "Make two strokes of this, at a place": "从一处分成两笔",
    "Take the last correction back": "收回上一次更正", "Correct it again": "重新更正",
    "Drag them, and find the strokes anew": "拖动四角，重新寻找笔画",
    "As a file that can be written and corrected": "存为可写、可改的文件",
    "Finding the strokes…": "正在寻找笔画…", "There are no strokes": "没有笔画",
    "{piece}: stroke {k} of {n}": "字“{piece}”：第 {k} 笔，共 {n} 笔",
    "Click a stroke, or go through them by ← and →. Each begins at its number.":
        "单击一笔，或用 ← → 逐笔选择。每笔从编号处起笔。",
    "Click the stroke to join it to, or choose by ← and → and press Return.":
        "单击要合并的一笔，或用 ← → 选择后按回车。",
    "Click where to split it, or move the cut by ← and → and press Return.":
        "单击要分开之处，或用 ← → 移动分处后按回车。",
    "Drag the corners of the sheet, or move one by the arrows (1 to 4 choose it). "
    "Return finds the strokes anew, Esc leaves them.":
        "拖动纸的四角，或用方向键移动一角（按 1 到 4 选择）。回车重新寻找笔画，Esc 作罢。",
    "Corrected strokes could not be laid out and are not saved": "更正的笔画未能放上，也未保存",
    "The corrections are not used and not saved": "更正尚未使用，也未保存",
    "Drop them": "放弃更正",
}  # fmt: skip


# --------------------------------------------------------------------------------------------------


_COMMANDS = re.compile(r"\s*\([^()]*(?:pip install|npm |(?<![\w-])--[a-z])[^()]*\)")
# Remarks for who types commands, which say nothing in a window.

_texts = [Texts("en")]
_unit = ["mm"]


def choose_language(code: str) -> None:
    """Speak "en", "zh" or as the "system" from now on; what is open keeps its words."""
    _texts[0] = Texts(code)


def choose_unit(unit: str) -> None:
    """Tell lengths in "mm", "cm", "m" or "in" from now on."""
    _unit[0] = unit


def say_length(mm: float) -> str:
    """A length in words, in the unit that was chosen."""
    number = mm / UNITS_MM[_unit[0]]
    return f"{number:.0f} {_unit[0]}" if number >= 100.0 else f"{number:.3g} {_unit[0]}"


def language() -> str:
    """The language that is spoken: "en" or "zh"."""
    return _texts[0].language


def say(text: str, **values: Any) -> str:
    """The words for a key or an English text, with values put in."""
    if text in load_texts():
        return _texts[0](text, **values)
    words = CHINESE.get(text, text) if language() == "zh" else text
    return words.format(**values) if values else words


def say_layer(name: str) -> str:
    """What a layer is called: one that nobody named has only a number."""
    return say("layer.name", number=name) if name.isdigit() else name


def say_brush(name: str) -> str:
    """What a brush is called: one of the user's own as its file says, were it a text's key."""
    return say(name) if name in brush_names() else name


def say_material(material: Material) -> str:
    """What a material is called: one of the user's own as its file says."""
    if material.name in load_materials():
        return say(f"surface.{material.name.replace(' ', '_')}")
    return material.chinese if language() == "zh" and material.chinese else material.name


def say_object(name: str) -> str:
    """What a built-in object or a form of sheets is called."""
    return say(f"object.{name.replace('-', '_')}")


def say_error(error: BaseException | str) -> str:
    """What went wrong, in the language that is spoken."""
    if isinstance(error, LayerError):
        return say(f"layer.is_{error.state}", name=say_layer(error.layer))
    if isinstance(error, GlyphError):
        return say(
            "No form of {characters} is known: install a font that has one, such as Noto Serif "
            "CJK, or choose another font",
            characters=error.characters,
        )
    message = _COMMANDS.sub("", str(error))
    return in_chinese(message) if language() == "zh" else message
