/**
 * The paper of a sheet as the picture shows it, clouds and single fibres: `paint3d/view/paper.py`, which
 * says how it is made. How it looks is set by eye there; only its random numbers are others here.
 */

const TILE_MM = 64.0;
export const TILE_PIXELS = 1024;
const COARSE = 256; // pixels that hold the clouds
const FIBRES = 5200; // on a tile
const LONG_MM = 8.0; // the longest
const STEP_MM = 0.05; // between points of a fibre
const BENDS = 0.03; // rad a step, standard deviation
const WIDE = 0.8; // pixels, standard deviation across
const [PALE, DARK] = [1.0, -0.7]; // of fibres, before they are scaled
const [CLOUD_MM, CLOUDS_FALL] = [1.3, 0.12]; // size below which clouds fade; per mm, from where they fall
const [CLOUDS, THREADS] = [0.006, 0.01]; // standard deviations of clouds and fibres, of linear light
const RANGE = 0.08; // of the light, from 0 to 255 of a tile

/** GLSL that reads the tile: how bright a point of the object, mm, is over the mean, in linear light. */
export const PAPER = `
uniform sampler2D paper_tile;
float paper(vec3 place, float amount) {
  vec3 facing = abs(cross(dFdx(place), dFdy(place)));
  vec2 at = place.xy;
  if (facing.x > max(facing.y, facing.z)) at = place.yz;
  else if (facing.y > facing.z) at = place.zx;
  at /= ${TILE_MM.toFixed(1)};
  vec2 other = 1.37 * mat2(0.8, -0.6, 0.6, 0.8) * at + vec2(0.31, 0.17);
  float light = texture(paper_tile, at).r + texture(paper_tile, other).r - 1.0;
  return 1.0 + amount * ${RANGE.toFixed(3)} * light;
}`;

let drawn: Uint8Array | null = null;

/** The tile, rows of codes about a mean of 128, which repeats on both axes. */
export function paperTile(): Uint8Array {
  if (drawn !== null) return drawn;
  const random = uniform(5);
  const [clouds, threads] = [drawClouds(random), drawThreads(random)];
  drawn = new Uint8Array(TILE_PIXELS * TILE_PIXELS);
  const [ofClouds, ofThreads] = [CLOUDS / deviation(clouds), THREADS / deviation(threads)];
  for (let i = 0; i < drawn.length; i++) {
    const light = ofClouds * clouds[i] + ofThreads * threads[i];
    drawn[i] = Math.round(255.0 * Math.min(1.0, Math.max(0.0, 0.5 + light / RANGE)));
  }
  return drawn;
}

/** Random numbers above 0 and below 1, always the same (mulberry32). */
function uniform(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return (((mixed ^ (mixed >>> 14)) >>> 0) + 0.5) / 4294967296;
  };
}

/** A normal random number, of standard deviation 1. */
function normal(random: () => number): number {
  return Math.sqrt(-2.0 * Math.log(random())) * Math.cos(2.0 * Math.PI * random());
}

/** Noise of a spectrum that fades: random waves, summed coarsely, and interpolated. */
function drawClouds(random: () => number): Float32Array {
  const n = COARSE;
  const [re, im] = [new Float64Array(n * n), new Float64Array(n * n)];
  for (let i = 1; i < n * n; i++) {
    const [row, column] = [Math.floor(i / n), i % n];
    const cycles = Math.hypot(Math.min(row, n - row), Math.min(column, n - column)) / TILE_MM; // to the mm
    const band = Math.exp(-((cycles * CLOUD_MM) ** 2)) / (1.0 + (cycles / CLOUDS_FALL) ** 2) ** 0.75;
    re[i] = band * normal(random);
    im[i] = band * normal(random);
  }
  for (let k = 0; k < n; k++) transform(re, im, k * n, 1, n);
  for (let k = 0; k < n; k++) transform(re, im, k, n, n);
  const clouds = new Float32Array(TILE_PIXELS * TILE_PIXELS);
  const times = TILE_PIXELS / n;
  for (let i = 0; i < clouds.length; i++) {
    const [row, column] = [Math.floor(i / TILE_PIXELS) / times, (i % TILE_PIXELS) / times];
    const [r, c] = [Math.floor(row), Math.floor(column)];
    const [below, right] = [(r + 1) % n, (c + 1) % n];
    const [y, x] = [row - r, column - c];
    const above = re[r * n + c] * (1.0 - x) + re[r * n + right] * x;
    clouds[i] = above * (1.0 - y) + (re[below * n + c] * (1.0 - x) + re[below * n + right] * x) * y;
  }
  return clouds;
}

/** Fourier transform in place (Cooley and Tukey) of n numbers, a power of 2, `stride` apart. */
function transform(re: Float64Array, im: Float64Array, first: number, stride: number, n: number): void {
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

/** Bent fibres, pale and dark, that fade at their ends. */
function drawThreads(random: () => number): Float32Array {
  const threads = new Float32Array(TILE_PIXELS * TILE_PIXELS);
  const wrapped = (mm: number): number => Math.floor(mm * (TILE_PIXELS / TILE_MM)) & (TILE_PIXELS - 1);
  for (let fibre = 0; fibre < FIBRES; fibre++) {
    const gamma = -Math.log(random() * random() * random() * random()); // of shape 4
    const length = Math.min(gamma + 1.0, LONG_MM);
    let turn = 2.0 * Math.PI * random();
    let [x, y] = [TILE_MM * random(), TILE_MM * random()];
    const shade = (random() < 0.5 ? PALE : DARK) * (0.3 + 0.7 * random());
    for (let along = 0.0; along < length; along += STEP_MM) {
      turn += BENDS * normal(random);
      x += STEP_MM * Math.cos(turn);
      y += STEP_MM * Math.sin(turn);
      threads[wrapped(y) * TILE_PIXELS + wrapped(x)] += shade * Math.sin((Math.PI * along) / length);
    }
  }
  return blurred(blurred(threads));
}

/** The same with rows and columns exchanged, and blurred along what were its rows. */
function blurred(field: Float32Array): Float32Array {
  const far = 3; // pixels
  const weights = Array.from({ length: 2 * far + 1 }, (_, k) => Math.exp(-0.5 * ((k - far) / WIDE) ** 2));
  const soft = new Float32Array(field.length);
  for (let row = 0; row < TILE_PIXELS; row++)
    for (let column = 0; column < TILE_PIXELS; column++) {
      let sum = 0.0;
      for (let k = -far; k <= far; k++)
        sum += weights[k + far] * field[row * TILE_PIXELS + ((column + k) & (TILE_PIXELS - 1))];
      soft[column * TILE_PIXELS + row] = sum;
    }
  return soft;
}

/** The standard deviation of a field, whose mean is taken from it. */
function deviation(field: Float32Array): number {
  const mean = field.reduce((sum, value) => sum + value, 0.0) / field.length;
  for (let i = 0; i < field.length; i++) field[i] -= mean;
  return Math.sqrt(field.reduce((sum, value) => sum + value * value, 0.0) / field.length);
}
