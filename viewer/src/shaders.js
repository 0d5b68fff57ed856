// What the graphics card runs. Everything is cut by one plane: cut.xyz points away from what stays.
// SPDX-License-Identifier: Apache-2.0

export const surfaceVertex = `
attribute float off;
varying vec3 vNormal, vPlace;
varying float vOff;
void main() {
  vec4 place = modelMatrix * vec4(position, 1.0);
  vNormal = normal;
  vPlace = place.xyz;
  vOff = off;
  gl_Position = projectionMatrix * viewMatrix * place;
}`;

// coloring: 0 element, 1 height, 2 slope, 3 deviation, 4 what a cutter leaves.
export const surfaceFragment = `
uniform vec3 color;
uniform int coloring;
uniform float block, dim, glow, alpha, occluded;
uniform vec2 range;
uniform vec4 cut, shadeBox, cutBox;
uniform float shadeCell, shadeReach, bottom, span;
uniform sampler2D scale, shade, cutMap;
varying vec3 vNormal, vPlace;
varying float vOff;

// Part of the sky that is seen from here; a wall sees more of it the higher above its foot.
float sky(vec3 n) {
  if (occluded < 0.5 || n.z < -0.05) return 1.0;
  vec2 foot = vPlace.xy + n.xy * shadeCell * 1.6;
  vec4 ground = texture2D(shade, (foot - shadeBox.xy) * shadeBox.zw);
  float above = vPlace.z - (bottom + ground.g * span);
  return mix(ground.r, 1.0, smoothstep(0.0, shadeReach, above) * (1.0 - n.z));
}

void main() {
  if (dot(cut.xyz, vPlace) > cut.w) discard;
  vec3 n = normalize(vNormal);
  vec3 own = color;
  if (block < 0.5) {
    if (coloring == 1) own = texture2D(scale, vec2((vPlace.z - range.x) / (range.y - range.x), 0.5)).rgb;
    if (coloring == 2) own = texture2D(scale, vec2(degrees(acos(min(1.0, abs(n.z)))) / 90.0, 0.5)).rgb;
    if (coloring == 3) own = vOff > 1e30 ? vec3(0.70) : texture2D(scale, vec2((vOff - range.x) / (range.y - range.x), 0.5)).rgb;
    if (coloring == 4) {
      vec4 left = texture2D(cutMap, (vPlace.xy - cutBox.xy) * cutBox.zw);
      own = left.a < 0.5 || n.z < 0.001 ? vec3(0.70) : left.rgb;
    }
  } else if (coloring > 0) {
    own = vec3(0.62, 0.63, 0.65);
  }
  vec3 seen = normalize((viewMatrix * vec4(n, 0.0)).xyz);
  bool inside = seen.z < 0.0;
  if (inside) seen = -seen;
  float key = max(0.0, dot(seen, normalize(vec3(-0.42, 0.58, 0.70))));
  float fill = max(0.0, dot(seen, normalize(vec3(0.75, -0.10, 0.55))));
  float open = mix(0.34, 1.0, sky(n));
  float light = (0.40 + 0.14 * seen.z) * open + 0.42 * key * mix(0.55, 1.0, open) + 0.12 * fill;
  float gloss = 0.10 * pow(max(0.0, dot(seen, normalize(vec3(-0.21, 0.29, 0.93)))), 40.0) * open;
  vec3 result = own * light + vec3(gloss);
  if (inside && block < 0.5) result *= 0.72;
  result = mix(result, vec3(dot(result, vec3(0.3, 0.5, 0.2))) * 0.6 + 0.32, dim * 0.72);
  result = mix(result, vec3(1.0), glow);
  gl_FragColor = vec4(result, alpha);
}`;

// A stroke of some pixels' width from one end to the other of each instance.
export const strokeVertex = `
attribute vec3 from, to;
attribute float kind;
uniform vec2 screen;
uniform float width, lift;
varying vec3 vPlace;
varying float vKind, vAlong;
void main() {
  vec4 a = projectionMatrix * viewMatrix * vec4(from, 1.0), b = projectionMatrix * viewMatrix * vec4(to, 1.0);
  vec2 along = (b.xy - a.xy) * screen;
  float size = length(along);
  along = size > 1e-6 ? along / size : vec2(1.0, 0.0);
  vec4 p = position.y < 0.5 ? a : b;
  p.xy += (vec2(-along.y, along.x) * position.x + along * (position.y * 2.0 - 1.0) * 0.5) * width / screen;
  p.z -= lift;
  vPlace = position.y < 0.5 ? from : to;
  vKind = kind;
  vAlong = position.y * size * 0.5;
  gl_Position = p;
}`;

export const strokeFragment = `
uniform vec3 color, color2;
uniform float alpha;
uniform vec4 cut;
varying vec3 vPlace;
varying float vKind, vAlong;
void main() {
  if (dot(cut.xyz, vPlace) > cut.w) discard;
  if (vKind > 0.5 && mod(vAlong, 9.0) > 5.0) discard;
  gl_FragColor = vec4(vKind > 0.5 ? color2 : color, alpha);
}`;

export const capVertex = `
varying vec3 vPlace;
void main() {
  vPlace = position;
  gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
}`;

// Hatched at 45 degrees, as a drawing is.
export const capFragment = `
uniform vec3 color, ink;
uniform vec3 across;
uniform float pitch;
varying vec3 vPlace;
void main() {
  float at = dot(across, vPlace) / pitch;
  float wide = max(fwidth(at), 1e-6);
  float line = abs(fract(at) - 0.5);
  float hatch = 1.0 - smoothstep(0.5 * wide, 1.5 * wide, line);
  hatch *= 1.0 - smoothstep(0.25, 0.6, wide);
  gl_FragColor = vec4(mix(color, ink, 0.45 * hatch), 1.0);
}`;
