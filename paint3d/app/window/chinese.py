"""The Chinese of what the window says, by its English."""

from __future__ import annotations

__all__ = ["CHINESE"]

CHINESE = {
    # menus and commands
    "&File": "文件(&F)", "&Edit": "编辑(&E)", "&View": "视图(&V)", "&Brush": "笔墨(&B)",
    "&Layers": "图层(&L)", "&Help": "帮助(&H)",
    "New painting…": "新作…", "Open…": "打开…", "Open recent": "最近打开", "Save": "保存",
    "Save as…": "另存为…", "Export…": "导出…", "Replay a recording…": "重演录制…",
    "Save the strokes as a recording…": "将笔画存为录制…", "Picture of the view…": "视图截图…",
    "Turntable film…": "转台影片…", "Quit": "退出", "Undo": "撤销", "Redo": "重做",
    "Let everything dry": "全部晾干", "Let ink run while painting": "作画时任墨洇化",
    "Show the whole object": "显示全貌", "From the front": "正面", "From the right": "右面",
    "From above": "俯视", "Show the brush": "显示毛笔", "Dark theme": "深色界面",
    "Full screen": "全屏", "Dip in the same ink": "再蘸同墨", "Rinse": "洗笔",
    "Wipe half off": "舔去一半", "Swap the two inks": "换用另一墨",
    "Pick up the ink under the pointer": "吸取笔下之墨", "Smaller brush": "笔小些",
    "Larger brush": "笔大些", "Mirror left and right": "左右对称",
    "Keys and gestures": "按键与手势", "About paint3d": "关于 paint3d", "English": "English",
    "中文": "中文", "Tools": "工具",
    # panels
    "Brushes": "毛笔", "Inks": "墨与颜料", "Layers": "图层", "Strokes": "笔画", "Tuft": "笔头",
    "Water": "水", "Dip": "蘸墨", "Empty": "倒空", "Only the tip": "只蘸笔尖",
    "Mixing dish: stir inks in with the right button": "调色碟：用右键把颜料调进来",
    "Click: dip. Right button or Ctrl: stir a part into the mixing dish":
        "单击：蘸墨。右键或 Ctrl：取一份调入碟中",
    "New layer": "新图层", "Remove layer": "删除图层", "Move up": "上移", "Move down": "下移",
    "Hide": "隐藏", "Show": "显示", "Lock": "锁定", "Unlock": "解锁", "Layer {name}": "图层 {name}",
    "Replay": "重演", "undone": "已撤销",
    "{n} strokes, {seconds:.1f} s": "{n} 笔，{seconds:.1f} 秒",
    "{hair} hair, {length:g} mm long, {width:g} mm thick":
        "{hair}，长 {length:g} 毫米，粗 {width:g} 毫米",
    "goat": "羊毫", "weasel": "狼毫", "mixed": "兼毫",
    "full": "满毫", "slender": "细长", "calibrated": "标定", "xiaokai": "小楷", "zhongkai": "中楷",
    "dakai": "大楷", "gongbi": "工笔", "baiyun": "白云", "xiaobaiyun": "小白云",
    "zhongbaiyun": "中白云", "dabaiyun": "大白云",
    "bowl": "碗", "plate": "盘", "vase": "瓶", "sphere": "球", "plane": "平面",
    "porcelain": "瓷", "bisque": "素胎", "xuan": "宣纸", "plaster": "石膏", "terracotta": "陶",
    # what is told
    "Paint with the left button or a pen; turn with Alt or the middle button":
        "左键或压感笔作画；按 Alt 或中键转动",
    "Open an object, or drop a file here": "打开一件器物，或把文件拖到这里",
    "ink {share:.0f} %": "含墨 {share:.0f}%", "behind by {ms:.0f} ms": "落后 {ms:.0f} 毫秒",
    "keeps up, {ms:.1f} ms": "跟手，{ms:.1f} 毫秒", "Painting": "作画",
    "{fps:.0f} pictures/s": "每秒 {fps:.0f} 帧", "Saved {name}": "已保存 {name}",
    "Wrote {name}": "已写出 {name}", "Stopped": "已停止",
    "The language changes with the next start": "下次启动时换用此语言",
    # dialogs
    "Please wait": "请稍候", "Cancel": "取消", "Opening {name}…": "正在打开 {name}…",
    "Writing {name}…": "正在写出 {name}…", "Painting the recording…": "正在重演录制…",
    "Drawing the film…": "正在绘制影片…", "Refining the surface…": "正在细分表面…",
    "New painting": "新作", "Object": "器物", "Material": "材质", "Finest detail": "最细处",
    "A mesh file…": "网格文件…", "Begin": "开始", "Open": "打开", "Export": "导出",
    "Objects and paintings": "器物与作品", "Recordings": "录制", "All files": "所有文件",
    "Paintings": "作品", "Picture": "图片", "Film": "影片",
    "Which unit is {name} measured in?": "{name} 用的是什么长度单位？",
    "As {unit} it would be {size} long.": "若以{unit}计，它长 {size}。",
    "Unsaved painting": "作品尚未保存",
    "Save the changes to {name} before leaving it?": "离开之前，要保存 {name} 的改动吗？",
    "Something was left unfinished": "上次有未完成的作品",
    "paint3d ended without saving {name}. Everything up to {when} can be brought back.":
        "paint3d 上次未及保存 {name} 便已结束。{when} 以前的一切都可以找回。",
    "Brought back; save it to keep it": "已找回；请保存",
    "Bring it back": "找回", "Leave it": "不要了", "this painting": "这幅作品",
    "Left button or pen tip": "左键或笔尖", "Pen's other end": "笔的另一端",
    "Paint; a pen's pressure, tilt and twist are the brush's":
        "作画；笔的压力、倾斜、旋转即毛笔的动作",
    "Rinse the brush as it comes near": "靠近时洗笔",
    "Alt + drag, middle button": "Alt + 拖动，中键", "Turn around the object": "绕器物转动",
    "Shift + middle button": "Shift + 中键", "Move sideways": "平移",
    "Wheel, right button": "滚轮，右键", "Come nearer": "拉近",
    "F, held and dragged": "按住 F 拖动", "Size of the brush": "改变笔的大小",
    "Wheel while painting": "作画时滚轮", "Press harder or softer with a mouse": "鼠标下笔轻重",
    "Everything": "一切",
    "Paint calligraphy on objects with a brush that bends, spreads and runs dry as a real one "
    "does.":
        "用一支会弯、会散、会干的笔，在器物上写字作画。",
}  # fmt: skip
