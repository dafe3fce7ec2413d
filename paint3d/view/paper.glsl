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

// Codes of a point of the object, mm, where `more` of its ink is seen, which are `bare` without any. Ink that lets
// nothing through is seen alike, and dark ink nearly so but for pits; where it grows paler, fibres carry it on or keep
// it back. Not to be called in a branch.
vec3 in_grain(vec3 codes, vec3 bare, float more, vec3 place) {
  float rise = length(vec2(dFdx(codes.g), dFdy(codes.g))), pixel_mm = length(fwidth(place));
  float carried = CARRIED_MM * more * rise / max(pixel_mm, 1e-6) * (1.0 - smoothstep(0.06, 0.12, rise));  // no edges
  if (all(lessThan(abs(codes - bare), vec3(0.003)))) return codes;  // less than a step
  codes = clamp(codes - clamp(carried, -0.2, 0.2), min(codes, BLACK * bare), max(codes, bare));
  vec3 through = codes - BLACK * bare;
  vec3 fraction = clamp(through / max((1.0 - BLACK) * bare, 0.01), 0.08, 2.0);
  vec3 exponent = more * mix(vec3(IN_DARK), vec3(1.0), smoothstep(0.1, 0.5, fraction));
  exponent += PITS * min(more + PIT_FROM, 0.0);
  return codes + max(through, 0.0) * (pow(fraction, exponent) - 1.0);
}
