/**
 * The paper of a sheet as pages show it, clouds, single fibres, and grain in ink: `paint3d/view/paper.py` says what it
 * is. Numbers (`paper.json`) and shader (`paper.glsl`) are the same; only random numbers are others here.
 */

/**
 * @typedef {object} Fibres
 * @property {number} count
 * @property {number} shortest_mm
 * @property {number} scale_mm
 * @property {number} longest_mm
 * @property {number} bends
 * @property {number} wide_px
 * @property {number} dark
 */

/**
 * @typedef {object} Recipe
 * @property {number} tile_mm
 * @property {number} pixels a power of 2
 * @property {number} step_mm
 * @property {{ light: number, smallest_mm: number, falls_from: number }} clouds
 * @property {Fibres & { light: number }} fibres
 * @property {number} light_range
 * @property {{ size_px: number, weight: number }[]} specks
 * @property {Fibres & { weight: number }} short_fibres
 * @property {number} grain
 * @property {number} grain_range
 * @property {number} black
 * @property {number} in_dark
 * @property {number} pits
 * @property {number} pit_from
 * @property {number} carried_mm
 */

/**
 * GLSL that reads the tile, from that of `paper.glsl`.
 * @param {Recipe} recipe
 * @param {string} shader
 * @returns {string}
 */
export function paperShader(recipe, shader) {
  const numbers = { TILE_MM: recipe.tile_mm, PIXELS: recipe.pixels, LIGHT_RANGE: recipe.light_range,
                    GRAIN_RANGE: recipe.grain_range, BLACK: recipe.black, IN_DARK: recipe.in_dark,
                    PITS: recipe.pits, PIT_FROM: recipe.pit_from, CARRIED_MM: recipe.carried_mm }; // prettier-ignore
  const declared = Object.entries(numbers).map(([name, value]) => `const float ${name} = ${value.toFixed(6)};\n`);
  return `uniform sampler2D paperTile;\nconst bool QUICK = false;\n${declared.join("")}${shader}`;
}

/**
 * The tile, rows of two codes about a mean of 128, light and grain, which repeats on both axes.
 * @param {Recipe} recipe
 * @returns {Uint8Array}
 */
export function paperTile(recipe) {
  const random = uniform(5);
  const { pixels, clouds, fibres, short_fibres: short } = recipe;
  const light = new Float32Array(pixels * pixels);
  const grain = new Float32Array(pixels * pixels);
  add(light, clouds.light, drawClouds(recipe, random));
  add(light, fibres.light, drawFibres(recipe, fibres, random));
  add(grain, -short.weight, drawFibres(recipe, short, random)); // pale ones take less
  for (const { size_px, weight } of recipe.specks) {
    const white = new Float32Array(light.length);
    for (let i = 0; i < white.length; i++) white[i] = random() - 0.5;
    add(grain, weight, blurred(blurred(white, pixels, size_px), pixels, size_px));
  }
  even(grain);
  const [ofLight, ofGrain] = [255.0 / recipe.light_range, (255.0 * Math.SQRT1_2 * recipe.grain) / recipe.grain_range];
  const tile = new Uint8ClampedArray(2 * light.length); // which rounds
  for (let i = 0; i < light.length; i++) {
    tile[2 * i] = 128.0 + ofLight * light[i];
    tile[2 * i + 1] = 128.0 + ofGrain * grain[i]; // the tile is read twice
  }
  return new Uint8Array(tile.buffer);
}

/**
 * Add so much of a field, evened, to another.
 * @param {Float32Array} sum
 * @param {number} weight
 * @param {Float32Array} field
 */
function add(sum, weight, field) {
  even(field);
  for (let i = 0; i < sum.length; i++) sum[i] += weight * field[i];
}

/**
 * Let a field have mean 0 and standard deviation 1.
 * @param {Float32Array} field
 */
function even(field) {
  let [mean, square] = [0.0, 0.0];
  for (const value of field) mean += value / field.length;
  for (const value of field) square += (value - mean) ** 2 / field.length;
  for (let i = 0; i < field.length; i++) field[i] = (field[i] - mean) / Math.sqrt(square);
}

/**
 * Random numbers above 0 and below 1, always the same (mulberry32).
 * @param {number} seed
 * @returns {() => number}
 */
function uniform(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return (((mixed ^ (mixed >>> 14)) >>> 0) + 0.5) / 4294967296;
  };
}

/**
 * A normal random number, of standard deviation 1.
 * @param {() => number} random
 */
function normal(random) {
  return Math.sqrt(-2.0 * Math.log(random())) * Math.cos(2.0 * Math.PI * random());
}

/**
 * Noise of a spectrum that fades: random waves, summed coarsely, and interpolated.
 * @param {Recipe} recipe
 * @param {() => number} random
 */
function drawClouds({ tile_mm, pixels, clouds: { smallest_mm, falls_from } }, random) {
  const n = pixels / 4; // that hold the clouds
  const [re, im] = [new Float64Array(n * n), new Float64Array(n * n)];
  for (let i = 1; i < n * n; i++) {
    const [row, column] = [Math.floor(i / n), i % n];
    const cycles = Math.hypot(Math.min(row, n - row), Math.min(column, n - column)) / tile_mm; // to the mm
    const band = Math.exp(-((cycles * smallest_mm) ** 2)) / (1.0 + (cycles / falls_from) ** 2) ** 0.75;
    re[i] = band * normal(random);
    im[i] = band * normal(random);
  }
  for (let k = 0; k < n; k++) transform(re, im, k * n, 1, n);
  for (let k = 0; k < n; k++) transform(re, im, k, n, n);
  const clouds = new Float32Array(pixels * pixels);
  for (let i = 0; i < clouds.length; i++) {
    const [row, column] = [Math.floor(i / pixels) / 4, (i % pixels) / 4];
    const [r, c] = [Math.floor(row), Math.floor(column)];
    const [below, right] = [(r + 1) % n, (c + 1) % n];
    const [y, x] = [row - r, column - c];
    const above = re[r * n + c] * (1.0 - x) + re[r * n + right] * x;
    clouds[i] = above * (1.0 - y) + (re[below * n + c] * (1.0 - x) + re[below * n + right] * x) * y;
  }
  return clouds;
}

/**
 * Fourier transform in place (Cooley and Tukey) of n numbers, a power of 2, `stride` apart.
 * @param {Float64Array} re
 * @param {Float64Array} im
 * @param {number} first
 * @param {number} stride
 * @param {number} n
 */
function transform(re, im, first, stride, n) {
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; (j & bit) !== 0; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i >= j) continue;
    const [a, b] = [first + i * stride, first + j * stride];
    [re[a], re[b]] = [re[b], re[a]];
    [im[a], im[b]] = [im[b], im[a]];
  }
  for (let half = 1; half < n; half *= 2)
    for (let k = 0; k < half; k++) {
      const [cos, sin] = [Math.cos((Math.PI * k) / half), Math.sin((Math.PI * k) / half)];
      for (let i = k; i < n; i += 2 * half) {
        const [a, b] = [first + i * stride, first + (i + half) * stride];
        const [x, y] = [re[b] * cos - im[b] * sin, re[b] * sin + im[b] * cos];
        [re[b], im[b]] = [re[a] - x, im[a] - y];
        re[a] += x;
        im[a] += y;
      }
    }
}

/**
 * Bent fibres, pale and dark, that fade at their ends.
 * @param {Recipe} recipe
 * @param {Fibres} about
 * @param {() => number} random
 */
function drawFibres({ tile_mm, pixels, step_mm }, about, random) {
  const drawn = new Float32Array(pixels * pixels);
  /** @param {number} mm */
  const wrapped = (mm) => Math.floor(mm * (pixels / tile_mm)) & (pixels - 1);
  for (let fibre = 0; fibre < about.count; fibre++) {
    const gamma = -Math.log(random() * random() * random() * random()); // of shape 4
    const length = Math.min(about.shortest_mm + about.scale_mm * gamma, about.longest_mm);
    let turn = 2.0 * Math.PI * random();
    let [x, y] = [tile_mm * random(), tile_mm * random()];
    const shade = (random() < 0.5 ? 1.0 : about.dark) * (0.3 + 0.7 * random());
    for (let along = 0.0; along < length; along += step_mm) {
      turn += about.bends * normal(random);
      x += step_mm * Math.cos(turn);
      y += step_mm * Math.sin(turn);
      drawn[wrapped(y) * pixels + wrapped(x)] += shade * Math.sin((Math.PI * along) / length);
    }
  }
  return blurred(blurred(drawn, pixels, about.wide_px), pixels, about.wide_px);
}

/**
 * The same with rows and columns exchanged, and blurred along what were its rows.
 * @param {Float32Array} field
 * @param {number} n of its pixels along a side
 * @param {number} wide pixels, standard deviation
 */
function blurred(field, n, wide) {
  const far = Math.ceil(3.0 * wide);
  const weights = Float64Array.from({ length: 2 * far + 1 }, (_, k) => Math.exp(-0.5 * ((k - far) / wide) ** 2));
  const soft = new Float32Array(field.length);
  const line = new Float64Array(n + 2 * far);
  for (let row = 0; row < n; row++) {
    for (let k = 0; k < line.length; k++) line[k] = field[row * n + ((k - far) & (n - 1))];
    for (let column = 0; column < n; column++) {
      let sum = weights[far] * line[column + far];
      for (let k = 0; k < far; k++) sum += weights[k] * (line[column + k] + line[column + 2 * far - k]);
      soft[column * n + row] = sum;
    }
  }
  return soft;
}
