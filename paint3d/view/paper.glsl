// Of a point of the object, mm: how bright its paper is over the mean, in linear light, and how much more of its ink
// is seen there, in exponents of what the ink lets through.
vec2 paper(vec3 place) {
  vec3 facing = abs(cross(dFdx(place), dFdy(place)));
  vec2 at = place.xy;
  if (facing.x > max(facing.y, facing.z)) at = place.yz;
  else if (facing.y > facing.z) at = place.zx;
  at /= TILE_MM;
  vec2 read = texture(paperTile, at).rg - 128.0 / 255.0;
  if (QUICK) {  // once, as uneven, and without smaller copies of the tile
    read *= 1.4;
    read.y *= min(1.0, 1.5 / (PIXELS * length(fwidth(at)) + 1e-6));
  } else {
    vec2 other = 1.37 * mat2(0.8, -0.6, 0.6, 0.8) * at + vec2(0.31, 0.17);
    read += texture(paperTile, other).rg - 128.0 / 255.0;
  }
  return read * vec2(LIGHT_RANGE, GRAIN_RANGE);
}

// Codes of a point where `more` of its ink is seen, which are `bare` without any. Ink that lets nothing through is
// seen alike.
vec3 in_grain(vec3 codes, vec3 bare, float more) {
  if (all(lessThan(abs(codes - bare), vec3(0.003)))) return codes;  // less than a step
  vec3 through = codes - BLACK * bare;
  vec3 fraction = clamp(through / max((1.0 - BLACK) * bare, 0.01), 0.08, 2.0);
  return codes + max(through, 0.0) * (pow(fraction, vec3(more)) - 1.0);
}
