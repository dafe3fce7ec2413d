/** The picture of the object, by WebGL 2, kept in step with the painting. */

import type { Vector } from "../core/quaternion";
import type { Camera } from "./camera";
import type { Guides } from "./copybook";
import { paperShader, paperTile } from "../../../paint3d/files/viewer/paper.js";
import PAPER_SHADER from "../../../paint3d/view/paper.glsl?raw";
import PAPER from "../../../paint3d/view/paper.json";
import { AXES, type PictureChange } from "./picture_feed";

// The sky is white above, greyer at the horizon, and the table below throws a little light back. A
// lamp to the upper left gives the form; what a glaze mirrors of both is added.
const LIGHT = `
const vec3 LAMP = normalize(vec3(-0.45, -0.35, 0.82));
vec3 sky(vec3 d) {
  float up = d.z;
  vec3 high = mix(vec3(0.74, 0.75, 0.77), vec3(1.0), smoothstep(-0.1, 0.9, up));
  float window = smoothstep(0.90, 0.96, dot(d, normalize(vec3(-0.55, -0.25, 0.75))));
  return mix(vec3(0.42, 0.40, 0.38), high, smoothstep(-0.25, 0.1, up)) + 1.5 * window;
}
vec3 encoded(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}
vec3 decoded(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}`;

let paperPixels: Uint8Array | null = null; // drawn once

const VERTEX = `#version 300 es
in float px; in float py; in float pz; in float nx; in float ny; in float nz;
in vec3 colour; in vec3 unpainted; in float openness;
uniform mat4 view;
out vec3 place; out vec3 normal; out vec3 code; out vec3 bare; out float open;
void main() {
  place = vec3(px, py, pz); normal = vec3(nx, ny, nz); code = colour; bare = unpainted; open = openness;
  gl_Position = view * vec4(place, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in vec3 place; in vec3 normal; in vec3 code; in vec3 bare; in float open;
uniform vec3 eye; uniform float roughness; uniform float flatness; uniform vec2 felted;
out vec4 shown;
${LIGHT}${paperShader(PAPER, PAPER_SHADER)}
void main() {
  vec3 n = normalize(normal), v = normalize(eye - place);
  if (dot(n, v) < 0.0 && !gl_FrontFacing) n = -n;
  vec2 sheet = felted * paper(place);
  vec3 paint = decoded(in_grain(code, bare, sheet.y, place)) * (1.0 + sheet.x);
  float seen = open / (1.0 - 0.72 * (1.0 - open));  // light that white walls throw back comes again
  float soft = max(0.0, dot(n, LAMP)) * smoothstep(0.1, 0.9, open);
  vec3 round = paint * (0.86 * seen * (0.80 + 0.20 * n.z) + 0.24 * soft);
  vec3 even = paint * (0.86 + 0.14 * max(0.0, dot(n, LAMP)));
  vec3 lit = mix(round, even, flatness);
  float grazing = pow(1.0 - max(dot(n, v), 0.0), 5.0);
  float mirrored = (0.035 + 0.4 * grazing * (1.0 - roughness)) * (1.0 - roughness);
  vec3 r = reflect(-v, n);
  vec3 seen_sky = mix(sky(r), vec3(0.85), roughness);
  lit += mirrored * seen_sky * mix(0.25, 1.0, seen);
  shown = vec4(encoded(lit), 1.0);
}`;

const LINE_VERTEX = `#version 300 es
in vec3 place;
uniform mat4 view;
void main() {
  gl_Position = view * vec4(place, 1.0);
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
uniform vec4 colour;
out vec4 shown;
void main() {
  shown = vec4(colour.rgb * colour.a, colour.a);
}`;
const OUTLINES = [0.78, 0.16, 0.12, 0.85] as const;
const GRID = [0.78, 0.16, 0.12, 0.3] as const;

const GROUND_VERTEX = `#version 300 es
in vec2 corner;
uniform mat4 view; uniform vec3 middle; uniform vec2 half_size; uniform float margin;
out vec2 at;
void main() {
  at = corner * (half_size + margin);
  gl_Position = view * vec4(middle + vec3(at, 0.0), 1.0);
}`;

// The shadow of what stands there: dark under it, soft around.
const GROUND_FRAGMENT = `#version 300 es
precision highp float;
in vec2 at;
uniform vec2 half_size; uniform float round_by; uniform float margin; uniform float depth;
out vec4 shown;
void main() {
  vec2 q = abs(at) - half_size + round_by;
  float off = length(max(q, 0.0)) + min(max(q.x, q.y), 0.0) - round_by;
  float dark = depth * pow(1.0 - clamp(off / margin, 0.0, 1.0), 2.4);
  shown = vec4(vec3(0.0), dark);
}`;

/** How a material looks, beside its colour. */
export interface Gloss {
  roughness: number;
  paper: [number, number]; // as `Material.paper`
}

/** A browser that cannot show the object. */
export class StageError extends Error {
  override name = "StageError";
}

export class Stage {
  readonly #gl: WebGL2RenderingContext;
  #program: WebGLProgram;
  #ground: WebGLProgram;
  #lines: WebGLProgram;
  #guides: { array: WebGLVertexArrayObject; buffer: WebGLBuffer; n: number; colour: readonly number[] }[] = [];
  #guided: Guides = { outlines: new Float32Array(), grid: new Float32Array() };
  #buffers: Record<string, WebGLBuffer> = {};
  #array: WebGLVertexArrayObject | null = null;
  #groundArray: WebGLVertexArrayObject | null = null;
  #capacity = 0;
  #corners = 0;
  #roughness = 1.0;
  #paper: [number, number] = [0.0, 0.0]; // how much of it is seen
  #tile: { texture: WebGLTexture; isPaper: boolean } | null = null;
  #foot: { middle: Vector; half: [number, number]; round: number; margin: number; depth: number } =
    { middle: [0, 0, 0], half: [1, 1], round: 1, margin: 1, depth: 0 }; // prettier-ignore
  flat = false;

  constructor(readonly canvas: HTMLCanvasElement) {
    const gl = canvas.getContext("webgl2", {
      antialias: true, alpha: true, premultipliedAlpha: true, preserveDrawingBuffer: true,
    }); // prettier-ignore
    if (gl === null) throw new StageError("WebGL 2");
    this.#gl = gl;
    [this.#program, this.#ground, this.#lines] = this.#link();
  }

  #link(): WebGLProgram[] {
    const gl = this.#gl;
    return [
      linked(gl, VERTEX, FRAGMENT), linked(gl, GROUND_VERTEX, GROUND_FRAGMENT), linked(gl, LINE_VERTEX, LINE_FRAGMENT),
    ]; // prettier-ignore
  }

  /** Begin again after the browser has taken everything and given the context back; a whole picture has to come. */
  restore(): void {
    [this.#program, this.#ground, this.#lines] = this.#link();
    this.#buffers = {};
    this.#array = this.#groundArray = null;
    this.#guides = [];
    this.#capacity = this.#corners = 0;
    this.#tile = null;
    this.guide(this.#guided);
  }

  /** Show another painting, of which a whole picture comes; `places`: x, y and z of its object's vertices. */
  open(places: readonly Float32Array[], { roughness, paper }: Gloss, flat: boolean): void {
    const gl = this.#gl;
    for (const buffer of Object.values(this.#buffers)) gl.deleteBuffer(buffer);
    if (this.#array !== null) gl.deleteVertexArray(this.#array);
    this.#buffers = {};
    this.#array = null;
    this.#capacity = this.#corners = 0;
    this.#roughness = roughness;
    this.#paper = paper;
    this.flat = flat;
    this.#place(places);
  }

  /** Show lines on the object in place of those before. */
  guide(lines: Guides): void {
    const gl = this.#gl;
    this.#guided = lines;
    for (const { array, buffer } of this.#guides) {
      gl.deleteVertexArray(array);
      gl.deleteBuffer(buffer);
    }
    const made = [[lines.grid, GRID], [lines.outlines, OUTLINES]] as const; // prettier-ignore
    this.#guides = made.map(([points, colour]) => {
      const array = gl.createVertexArray();
      const buffer = gl.createBuffer();
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, points, gl.STATIC_DRAW);
      const place = gl.getAttribLocation(this.#lines, "place");
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
      gl.bindVertexArray(null);
      return { array, buffer, n: points.length / 3, colour };
    });
  }

  get guides(): Guides {
    return this.#guided;
  }

  /** Where it stands, and the shadow that it throws. */
  #place([x, y, z]: readonly Float32Array[]): void {
    const n = z.length;
    let bottom = Infinity;
    let top = -Infinity;
    for (let i = 0; i < n; i++) [bottom, top] = [Math.min(bottom, z[i]), Math.max(top, z[i])];
    const low = [Infinity, Infinity];
    const high = [-Infinity, -Infinity];
    for (let i = 0; i < n; i++) {
      if (z[i] > bottom + 0.06 * (top - bottom) + 1e-3) continue;
      for (const [k, axis] of [x, y].entries()) {
        low[k] = Math.min(low[k], axis[i]);
        high[k] = Math.max(high[k], axis[i]);
      }
    }
    const half: [number, number] = [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])];
    const size = Math.min(half[0], half[1]);
    this.#foot = {
      middle: [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), bottom - (this.flat ? 0.3 : 0.01)],
      half,
      round: this.flat ? 0.02 * size : size,
      margin: this.flat ? 0.09 * size : 1.1 * size,
      depth: this.flat ? 0.24 : 0.5,
    };
  }

  /** Take up what has changed. */
  follow({ capacity, first, axes, openness, bare, low, codes, faces }: PictureChange): void {
    const gl = this.#gl;
    if (first === 0) this.#allocate(capacity);
    const write = (name: string, at: number, data: ArrayBufferView): void => {
      if (data.byteLength === 0) return;
      gl.bindBuffer(gl.ARRAY_BUFFER, this.#buffers[name]);
      gl.bufferSubData(gl.ARRAY_BUFFER, at, data);
    };
    for (const [k, name] of AXES.entries()) write(name, 4 * first, axes[k]);
    write("openness", first, openness);
    write("unpainted", 3 * first, bare);
    write("colour", 3 * low, codes);
    if (faces === null) return;
    gl.bindVertexArray(this.#array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.#buffers.faces);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.DYNAMIC_DRAW);
    gl.bindVertexArray(null);
    this.#corners = faces.length;
  }

  #allocate(capacity: number): void {
    const gl = this.#gl;
    for (const buffer of Object.values(this.#buffers)) gl.deleteBuffer(buffer);
    if (this.#array !== null) gl.deleteVertexArray(this.#array);
    this.#buffers = { faces: gl.createBuffer() };
    this.#array = gl.createVertexArray();
    gl.bindVertexArray(this.#array);
    const attribute = (name: string, size: number, type: number, bytes: number): void => {
      const buffer = (this.#buffers[name] = gl.createBuffer());
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, bytes * size * capacity, gl.DYNAMIC_DRAW);
      const at = gl.getAttribLocation(this.#program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, type, type !== gl.FLOAT, 0, 0);
    };
    for (const name of AXES) attribute(name, 1, gl.FLOAT, 4);
    attribute("colour", 3, gl.UNSIGNED_BYTE, 1);
    attribute("unpainted", 3, gl.UNSIGNED_BYTE, 1);
    attribute("openness", 1, gl.UNSIGNED_BYTE, 1);
    gl.bindVertexArray(null);
    this.#capacity = capacity;
  }

  /** Draw the picture as large as the canvas is shown. */
  draw(camera: Camera, withGuides = true): void {
    const gl = this.#gl;
    const { width, height } = this.canvas;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (this.#capacity === 0) return;
    const view = camera.matrix(width / height);
    this.#drawGround(view);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    gl.useProgram(this.#program);
    const at = (name: string): WebGLUniformLocation | null =>
      gl.getUniformLocation(this.#program, name);
    gl.uniformMatrix4fv(at("view"), false, view);
    gl.uniform3fv(at("eye"), camera.eye);
    gl.uniform1f(at("roughness"), this.#roughness);
    gl.uniform1f(at("flatness"), Number(this.flat));
    gl.uniform2fv(at("felted"), this.#paper);
    gl.bindTexture(gl.TEXTURE_2D, this.#paperTexture());
    gl.bindVertexArray(this.#array);
    gl.drawElements(gl.TRIANGLES, this.#corners, gl.UNSIGNED_INT, 0);
    if (withGuides) this.#drawGuides(view);
    gl.bindVertexArray(null);
  }

  /** The tile of paper; where none is seen one pixel, as a shader wants a texture in any case. */
  #paperTexture(): WebGLTexture {
    const gl = this.#gl;
    const isPaper = this.#paper.some((amount) => amount > 0.0);
    if (this.#tile !== null && (this.#tile.isPaper || !isPaper)) return this.#tile.texture;
    const [pixels, size] = isPaper ? [(paperPixels ??= paperTile(PAPER)), PAPER.pixels] : [Uint8Array.of(128, 128), 1];
    const texture = this.#tile?.texture ?? gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture); // it repeats by itself
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG8, size, size, 0, gl.RG, gl.UNSIGNED_BYTE, pixels);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    this.#tile = { texture, isPaper };
    return texture;
  }

  #drawGuides(view: Float32Array): void {
    const gl = this.#gl;
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.#lines);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.#lines, "view"), false, view);
    for (const { array, n, colour } of this.#guides) {
      gl.uniform4fv(gl.getUniformLocation(this.#lines, "colour"), colour);
      gl.bindVertexArray(array);
      gl.drawArrays(gl.LINES, 0, n);
    }
  }

  #drawGround(view: Float32Array): void {
    const gl = this.#gl;
    if (this.#groundArray === null) {
      this.#groundArray = gl.createVertexArray();
      gl.bindVertexArray(this.#groundArray);
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), gl.STATIC_DRAW);
      gl.enableVertexAttribArray(gl.getAttribLocation(this.#ground, "corner"));
      gl.vertexAttribPointer(gl.getAttribLocation(this.#ground, "corner"), 2, gl.FLOAT, false, 0, 0);
    }
    const { middle, half, round, margin, depth } = this.#foot;
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.#ground);
    const at = (name: string): WebGLUniformLocation | null =>
      gl.getUniformLocation(this.#ground, name);
    gl.uniformMatrix4fv(at("view"), false, view);
    gl.uniform3fv(at("middle"), middle);
    gl.uniform2fv(at("half_size"), half);
    gl.uniform1f(at("round_by"), round);
    gl.uniform1f(at("margin"), margin);
    gl.uniform1f(at("depth"), depth);
    gl.bindVertexArray(this.#groundArray);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }
}

function linked(gl: WebGL2RenderingContext, vertex: string, fragment: string): WebGLProgram {
  const program = gl.createProgram();
  for (const [kind, source] of [
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment],
  ] as const) {
    const shader = gl.createShader(kind);
    if (shader === null) throw new StageError("WebGL 2");
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
      throw new StageError(gl.getShaderInfoLog(shader) ?? "a shader");
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS))
    throw new StageError(gl.getProgramInfoLog(program) ?? "a program");
  return program;
}
