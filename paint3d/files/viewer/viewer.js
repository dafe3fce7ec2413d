"use strict";
// One mesh, seen from a turntable camera. Colours are interpolated and shown as sRGB codes, so that
// without light every pixel inside the object is the colour painted there; but where paint ends
// between vertices its edge is drawn sharp, as paint3d/view/edges.py says, and a sheet shows its paper
// (paper.js, which follows where there is one) unless the address ends in #paper=0.
(() => {
  const FIELD_OF_VIEW = 24 * Math.PI / 180; // of the shorter side
  // uint16 x y z, uint8 shares (where half, paint ends; painted), int8 nx ny nz 0, uint8 r g b 0,
  // uint8 r g b 0 without paint
  const BYTES_A_VERTEX = 20;
  const QUARTER = Math.PI / 2, TURN_A_KEY = Math.PI / 24, CLOSER_A_KEY = 1.15;
  const CLOSEST = 0.05, FARTHEST = 8; // distances, over the first one
  const FILLED = 0.86; // of the window, by the object as it is first seen

  const LIGHT_OF = `
    vec3 light_of(vec3 c) {
      return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
    }`;
  const VERTEX = `#version 300 es
    in vec3 place; in vec3 normal; in vec4 colour; in vec4 bare; in vec2 shares;
    uniform mat4 clip_from_mesh; uniform vec3 low, span;
    out vec3 facing, plain, bare_code, bare_light, ink_light, at; out vec2 covered;
    ${LIGHT_OF}
    void main() {
      facing = normal; plain = colour.rgb; bare_code = bare.rgb; covered = shares;
      bare_light = light_of(bare.rgb); ink_light = light_of(plain) - bare_light;
      at = low + span * place;
      gl_Position = clip_from_mesh * vec4(at, 1.0);
    }`;
  const FRAGMENT = (paper) => `#version 300 es
    precision highp float;
    in vec3 facing, plain, bare_code, bare_light, ink_light, at; in vec2 covered;
    uniform vec3 key, sky; uniform float lit, felted;
    out vec4 shown;
    ${paper}
    ${LIGHT_OF}
    vec3 codes_of(vec3 light) {
      return mix(light * 12.92, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055,
                 step(0.0031308, light));
    }
    void main() {
      vec3 painted = plain;
      float wide = 1.5 * length(vec2(dFdx(covered.x), dFdy(covered.x)));
      if (covered.x > 0.002 && covered.x < 0.998 && wide < 1.0) {
        float drawn = clamp((covered.x - 0.5) / max(wide, 0.02) + 0.5, 0.0, 1.0);
        vec3 light = clamp(bare_light + ink_light * drawn / max(covered.y, 0.08), 0.0, 1.0);
        float mean = dot(light, vec3(1.0 / 3.0));
        light = mix(vec3(mean), light, min(mean / 0.03, 1.0));
        painted = mix(codes_of(light), plain, smoothstep(0.5, 1.0, wide));
      }
      vec2 sheet = felted * SEEN_OF_PAPER * paper(at);
      if (felted > 0.0) {
        painted = in_grain(painted, bare_code, sheet.y, at);
        painted = codes_of(clamp(light_of(painted) * (1.0 + sheet.x), 0.0, 1.0));
      }
      if (lit == 0.0) { shown = vec4(painted, 1.0); return; }
      vec3 n = normalize(facing);
      if (!gl_FrontFacing) n = -n;
      float dome = 0.5 + 0.5 * dot(n, sky), box = max(0.0, 0.25 + 0.75 * dot(n, key));
      float light = 0.42 + 0.22 * dome + 0.40 * box;
      shown = vec4(codes_of(clamp(light_of(painted) * light, 0.0, 1.0)), 1.0);
    }`;

  const NO_PAPER = `
    const vec2 SEEN_OF_PAPER = vec2(0.0);
    vec2 paper(vec3 place) { return vec2(0.0); }
    vec3 in_grain(vec3 codes, vec3 bare, float more, vec3 at) { return codes; }`;

  const element = (id) => document.getElementById(id);
  const canvas = element("view");
  const about = JSON.parse(element("about").textContent);
  const span = about.high.map((h, k) => h - about.low[k]);
  const middle = about.low.map((l, k) => l + span[k] / 2);
  const radius = Math.hypot(...span) / 2 || 1;
  const camera = {};
  let gl, program, places, data, tile, waiting = false;

  function say(text) {
    const message = element("message");
    message.textContent = text;
    message.hidden = false;
  }

  async function unpack() {
    const text = atob(element("mesh").textContent);
    const packed = new Uint8Array(text.length);
    for (let k = 0; k < text.length; k++) packed[k] = text.charCodeAt(k);
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(stream).arrayBuffer();
  }

  function compile(type, source) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
      throw new Error(gl.getShaderInfoLog(shader));
    return shader;
  }

  function upload() {
    program = gl.createProgram();
    gl.attachShader(program, compile(gl.VERTEX_SHADER, VERTEX));
    const { paper } = about;
    const declared = !paper ? NO_PAPER
      : `const vec2 SEEN_OF_PAPER = vec2(${paper.amount});${paperShader(paper.recipe, paper.shader)}`;
    gl.attachShader(program, compile(gl.FRAGMENT_SHADER, FRAGMENT(declared)));
    gl.linkProgram(program);
    gl.useProgram(program);
    places = {};
    for (const name of ["clip_from_mesh", "low", "span", "key", "sky", "lit", "felted"])
      places[name] = gl.getUniformLocation(program, name);
    const vertexBytes = about.vertices * BYTES_A_VERTEX;
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Uint8Array(data, 0, vertexBytes), gl.STATIC_DRAW);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint8Array(data, vertexBytes), gl.STATIC_DRAW);
    const parts = [["place", 3, gl.UNSIGNED_SHORT, 0], ["shares", 2, gl.UNSIGNED_BYTE, 6],
                   ["normal", 3, gl.BYTE, 8], ["colour", 4, gl.UNSIGNED_BYTE, 12],
                   ["bare", 4, gl.UNSIGNED_BYTE, 16]];
    for (const [name, size, type, start] of parts) {
      const place = gl.getAttribLocation(program, name);
      if (place < 0) continue;
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, type, true, BYTES_A_VERTEX, start);
    }
    if (paper) lay(paper.recipe);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(143 / 255, 139 / 255, 133 / 255, 1);
  }

  function lay(recipe) {
    const { pixels } = recipe;
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());  // it repeats by itself
    tile = tile || paperTile(recipe);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG8, pixels, pixels, 0, gl.RG, gl.UNSIGNED_BYTE, tile);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  }

  function reset() {
    const wishes = new URLSearchParams(location.hash.slice(1));
    const wish = (name, usual) => {
      const number = parseFloat(wishes.get(name));
      return Number.isFinite(number) ? number : usual;
    };
    Object.assign(camera, {
      azimuth: wish("azimuth", about.azimuth) * Math.PI / 180,
      elevation: wish("elevation", about.elevation) * Math.PI / 180,
      closer: wish("zoom", 1), right: 0, up: 0,
    });
    camera.felted = wish("paper", about.paper ? 1 : 0);
    camera.first = fitted();
    show_light(wish("light", 0) !== 0);
    keep_in_range();
  }

  function keep_in_range() {
    camera.elevation = Math.max(-QUARTER, Math.min(QUARTER, camera.elevation));
    camera.closer = Math.max(1 / FARTHEST, Math.min(1 / CLOSEST, camera.closer));
    for (const way of ["right", "up"])
      camera[way] = Math.max(-radius, Math.min(radius, camera[way]));
    draw_soon();
  }

  function axes() {
    const [ca, sa] = [Math.cos(camera.azimuth), Math.sin(camera.azimuth)];
    const [ce, se] = [Math.cos(camera.elevation), Math.sin(camera.elevation)];
    return { right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce], back: [ce * ca, ce * sa, se] };
  }

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const distance = () => camera.first / camera.closer;

  // How far the camera must be for the object's box to fill the window as it stands.
  function fitted() {
    const { right, up, back } = axes(), shorter = Math.min(canvas.clientWidth, canvas.clientHeight);
    const half = FILLED * Math.tan(FIELD_OF_VIEW / 2) / Math.max(shorter, 1);
    let far = 1.2 * radius;
    for (let corner = 0; corner < 8; corner++) {
      const p = span.map((s, k) => (corner >> k & 1 ? 0.5 : -0.5) * s);
      const wide = Math.abs(dot(p, right)) / (half * Math.max(canvas.clientWidth, 1));
      const tall = Math.abs(dot(p, up)) / (half * Math.max(canvas.clientHeight, 1));
      far = Math.max(far, dot(p, back) + Math.max(wide, tall));
    }
    return far;
  }

  // mm that a CSS pixel covers at the middle of the object
  const mm_a_pixel = () => 2 * distance() * Math.tan(FIELD_OF_VIEW / 2) /
    Math.min(canvas.clientWidth, canvas.clientHeight);

  function draw() {
    waiting = false;
    if (!program || gl.isContextLost()) return;
    const scale = window.devicePixelRatio || 1;
    const width = Math.max(1, Math.round(canvas.clientWidth * scale));
    const height = Math.max(1, Math.round(canvas.clientHeight * scale));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    const { right, up, back } = axes(), far = distance();
    const eye = middle.map((m, k) =>
      m + camera.right * right[k] + camera.up * up[k] + far * back[k]);
    const tall = Math.tan(FIELD_OF_VIEW / 2) * Math.max(1, height / width);
    const away = dot(eye.map((e, k) => e - middle[k]), back);
    const near = Math.max(away - 1.01 * radius, 0.002 * radius), end = away + 1.01 * radius;
    const sx = height / width / tall, sy = 1 / tall, a = (end + near) / (near - end);
    const b = 2 * end * near / (near - end);
    const matrix = new Float32Array(16);
    for (let k = 0; k < 3; k++) {
      matrix[4 * k] = sx * right[k];
      matrix[4 * k + 1] = sy * up[k];
      matrix[4 * k + 2] = a * back[k];
      matrix[4 * k + 3] = -back[k];
    }
    matrix[12] = -sx * dot(right, eye);
    matrix[13] = -sy * dot(up, eye);
    matrix[14] = -a * dot(back, eye) + b;
    matrix[15] = dot(back, eye);
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(places.clip_from_mesh, false, matrix);
    gl.uniform3fv(places.low, about.low);
    gl.uniform3fv(places.span, span);
    const key = back.map((z, k) => 0.62 * z - 0.45 * right[k] + 0.64 * up[k]);
    gl.uniform3fv(places.key, key.map((x) => x / Math.hypot(...key)));
    gl.uniform3fv(places.sky, up);
    gl.uniform1f(places.felted, camera.felted);
    gl.uniform1f(places.lit, camera.light ? 1 : 0);
    gl.drawElements(gl.TRIANGLES, about.indices, gl.UNSIGNED_INT, 0);
  }

  function draw_soon() {
    if (!waiting) requestAnimationFrame(draw);
    waiting = true;
  }

  function show_light(on) {
    camera.light = on;
    element("light").setAttribute("aria-pressed", on);
    draw_soon();
  }

  function turn(x, y) {
    camera.azimuth -= x;
    camera.elevation += y;
    keep_in_range();
  }

  function move(x, y) {
    camera.right -= x * mm_a_pixel();
    camera.up += y * mm_a_pixel();
    keep_in_range();
  }

  function come_closer(times) {
    camera.closer *= times;
    keep_in_range();
  }

  const fingers = new Map();

  function spread() {
    const [a, b] = [...fingers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.hypot(a.x - b.x, a.y - b.y) };
  }

  function dragged(event) {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const now = { x: event.clientX, y: event.clientY };
    const before = fingers.size === 2 && spread();
    fingers.set(event.pointerId, now);
    if (before) {
      const after = spread();
      move(after.x - before.x, after.y - before.y);
      come_closer(after.apart / Math.max(before.apart, 1));
    } else if (fingers.size === 1 && (event.shiftKey || event.buttons & 6)) {
      move(now.x - last.x, now.y - last.y);
    } else if (fingers.size === 1) {
      const a_pixel = Math.PI / Math.min(canvas.clientWidth, canvas.clientHeight);
      turn((now.x - last.x) * a_pixel, (now.y - last.y) * a_pixel);
    }
  }

  function pressed(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const actions = {
      "+": () => come_closer(CLOSER_A_KEY), "=": () => come_closer(CLOSER_A_KEY),
      "-": () => come_closer(1 / CLOSER_A_KEY), "l": () => show_light(!camera.light),
      "r": reset, "home": reset,
    };
    if (way[event.key]) {
      const [x, y] = way[event.key];
      if (event.shiftKey) move(40 * x, 40 * y);
      else turn(-TURN_A_KEY * x, -TURN_A_KEY * y);
    } else if (actions[event.key.toLowerCase()]) {
      actions[event.key.toLowerCase()]();
    } else {
      return;
    }
    event.preventDefault();
  }

  function listen() {
    canvas.addEventListener("pointerdown", (event) => {
      canvas.focus({ focusVisible: false });
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    canvas.addEventListener("pointermove", dragged);
    for (const end of ["pointerup", "pointercancel"])
      canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : 1;
      come_closer(Math.exp(-0.0015 * event.deltaY * lines));
    }, { passive: false });
    document.addEventListener("keydown", pressed);
    element("light").addEventListener("click", () => show_light(!camera.light));
    element("closer").addEventListener("click", () => come_closer(CLOSER_A_KEY));
    element("farther").addEventListener("click", () => come_closer(1 / CLOSER_A_KEY));
    element("reset").addEventListener("click", reset);
    window.addEventListener("hashchange", reset);
    new ResizeObserver(() => { camera.first = fitted(); draw_soon(); }).observe(canvas);
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { upload(); draw_soon(); });
  }

  async function start() {
    gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
    if (!gl) return say("This browser shows no WebGL 2, which the object needs to be drawn.");
    if (!window.DecompressionStream)
      return say("This browser is too old to unpack the object; any of 2023 or later can.");
    if ("drawingBufferColorSpace" in gl) gl.drawingBufferColorSpace = "srgb";
    data = await unpack();
    upload();
    listen();
    reset();
    draw();
    document.documentElement.dataset.ready = "true";
  }

  start().catch((error) => say(`The object cannot be shown: ${error.message}`));
})();
