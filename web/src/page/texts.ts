/** What the page says, in English and in Chinese. */

const ENGLISH = {
  title: "paint3d",
  object: "On",
  brush: "Brush",
  ink: "Ink",
  press: "Pressure",
  size: "{mm} mm",
  dip: "Dip",
  dipAlways: "Dip before every stroke",
  erase: "Erase",
  undo: "Undo",
  redo: "Redo",
  fresh: "Start over",
  view: "Fit view",
  picture: "Picture",
  score: "Recording",
  load: "Open recording",
  notOpened: "{name} is no recording of a page with these objects, brushes and inks.",
  language: "中文",
  inkLeft: "Ink in the brush",
  more: "More",
  piece: "Piece",
  hand: "Hand",
  layers: "Layers",
  layer: "Layer {name}",
  addLayer: "Add layer",
  show: "Show",
  hide: "Hide",
  up: "Up",
  remove: "Remove",
  name: "Name",
  opacity: "Opacity",
  blend: "Blend",
  normal: "Normal",
  multiply: "Multiply",
  isHidden: "The layer that is painted on is hidden: show it, or paint on another one.",
  material: "Material",
  water: "Wet ink",
  spreads: "Spreads and dries",
  dry: "Dry now",
  keep: "Save",
  goOn: "Go on",
  page: "Page",
  hint: "Paint with a pen or a mouse. Right button: turn. Wheel: nearer. Ctrl+Z: take back.",
  hintTouch: "One finger or a pen paints. Two fingers turn the object and bring it nearer.",
  loading: "The studio is being loaded: {name}",
  repeating: "The piece is painted again: {percent} %",
  kept: "This browser keeps the piece; it is there again when you come back.",
  notKept: "This browser keeps nothing: save the piece before you leave.",
  leave: "What is painted here is lost if it was not saved. Begin anew?",
  noWasm: "This browser does not run WebAssembly with vectors (SIMD), by which the brush is computed.\nA newer Chrome, Edge, Firefox or Safari (16.4 or later) does.",
  noWebGl: "This browser gives no WebGL 2, by which the object is shown.\nIt may be turned off in its settings, or the graphics driver is too old.",
  noUnpacking: "This browser cannot unpack the studio's data (DecompressionStream).\nA newer Chrome, Edge, Firefox (113 or later) or Safari (16.4 or later) can.",
  noFile: "{name} cannot be had from this host ({status}).\nIs the folder whole that “paint3d page build” wrote, and is it handed out by a web server, not opened as a file?",
  failed: "Painting has ended: {cause}\nThe recording of what was painted can still be saved.",
  noMemory: "This browser has no memory left for the painting.\nThe recording of what was painted can still be saved.",
};

export type Texts = { [key in keyof typeof ENGLISH]: string };

const CHINESE: Texts = {
  title: "paint3d",
  object: "作于",
  brush: "笔",
  ink: "墨",
  press: "力度",
  size: "{mm} 毫米",
  dip: "蘸墨",
  dipAlways: "每笔先蘸",
  erase: "擦除",
  undo: "撤销",
  redo: "重做",
  fresh: "重来",
  view: "全貌",
  picture: "存图",
  score: "存谱",
  load: "打开谱",
  notOpened: "{name} 不是用此页的物体、笔、墨记录的谱。",
  language: "English",
  inkLeft: "笔中墨量",
  more: "更多",
  piece: "作品",
  hand: "手",
  layers: "图层",
  layer: "图层 {name}",
  addLayer: "新建图层",
  show: "显示",
  hide: "隐藏",
  up: "上移",
  remove: "删除",
  name: "名称",
  opacity: "不透明度",
  blend: "混合",
  normal: "正常",
  multiply: "正片叠底",
  isHidden: "当前图层已隐藏：请显示，或选另一图层。",
  material: "材质",
  water: "水墨",
  spreads: "洇散、变干",
  dry: "立即变干",
  keep: "保存",
  goOn: "继续",
  page: "页面",
  hint: "用压感笔或鼠标作画。右键旋转，滚轮缩放，Ctrl+Z 撤销。",
  hintTouch: "单指或笔作画。双指旋转、捏合缩放。",
  loading: "正在载入画室：{name}",
  repeating: "正在重现作品：{percent} %",
  kept: "作品保存在此浏览器中，下次打开时仍在。",
  notKept: "此浏览器无法保存作品，离开前请先存盘。",
  leave: "未保存的作品将会丢失。要重新开始吗？",
  noWasm: "此浏览器不支持带向量（SIMD）的 WebAssembly，无法计算笔触。\n请使用较新的 Chrome、Edge、Firefox 或 Safari（16.4 以上）。",
  noWebGl: "此浏览器没有 WebGL 2，无法显示物体。\n可能已在设置中关闭，或显卡驱动过旧。",
  noUnpacking: "此浏览器无法解压画室的数据（DecompressionStream）。\n请使用较新的 Chrome、Edge、Firefox（113 以上）或 Safari（16.4 以上）。",
  noFile: "无法从此主机取得 {name}（{status}）。\n“paint3d page build” 写出的文件夹是否完整？是否由网页服务器提供，而非直接打开文件？",
  failed: "作画已中断：{cause}\n已画部分的谱仍可保存。",
  noMemory: "浏览器内存不足。\n已画部分的谱仍可保存。",
};

const LANGUAGES = { en: ENGLISH as Texts, zh: CHINESE };
export type Language = keyof typeof LANGUAGES;

let spoken: Language = navigator.language.startsWith("zh") ? "zh" : "en";

export function language(): Language {
  return spoken;
}

export function choose(code: Language): void {
  spoken = code;
  document.documentElement.lang = code;
}

/** A text in the language that is spoken, with its fields put in. */
export function say(key: keyof Texts, fields: Record<string, string | number> = {}): string {
  return LANGUAGES[spoken][key].replace(/\{(\w+)\}/g, (_, name: string) => String(fields[name]));
}

/** A name in it. */
export function named(thing: { name: string; chinese: string }): string {
  if (spoken === "zh" && thing.chinese !== "") return thing.chinese;
  return thing.name;
}
