// The scene as the page's file says it: coordinates about the middle, in units of length.
// SPDX-License-Identifier: Apache-2.0
import {inflated, unpacked, unpackedNormals} from './packed.js';

export async function readScene(headText, bodyText) {
  const head = JSON.parse(headText);
  const bytes = await inflated(bodyText);
  const array = (name) => (head.arrays[name] ? unpacked(bytes, head.arrays[name]) : null);

  const bounds = head.bounds;
  // In whole steps, so that a vertex comes back as the number it was.
  const middle = [0, 1, 2].map((k) => Math.round((bounds[0][k] + bounds[1][k]) / 2 * head.per_unit));
  const shift = [0, 1, 2].map((k) => head.corner[k] - middle[k]);
  const placed = (steps) => {
    const places = new Float32Array(steps.length);
    for (let k = 0; k < steps.length; k += 3) {
      places[k] = (steps[k] + shift[0]) / head.per_unit;
      places[k + 1] = (steps[k + 1] + shift[1]) / head.per_unit;
      places[k + 2] = (steps[k + 2] + shift[2]) / head.per_unit;
    }
    return places;
  };

  const scene = {
    ...head,
    positions: placed(array('position')),
    normals: unpackedNormals(array('normal')),
    indices: array('index'),
    deviations: array('deviation'),
    curvePoints: placed(array('curve_point')),
    curveLengths: array('curve_length'),
    pathPoints: head.path ? placed(array('path_point')) : null,
    pathRapid: head.path ? array('path_rapid') : null,
    cutHeights: head.cut ? array('cut') : null,
    // From the drawn place to the scene's own coordinate: what a vertex is to the bit.
    own: (p) => [0, 1, 2].map((k) => (Math.round(p[k] * head.per_unit) + middle[k]) / head.per_unit),
    drawn: (p) => [0, 1, 2].map((k) => p[k] - middle[k] / head.per_unit),
  };
  let firstTriangle = 0, firstVertex = 0;
  for (const element of scene.elements) {
    Object.assign(element, {firstTriangle, firstVertex, shown: true});
    firstTriangle += element.triangles;
    firstVertex += element.vertices;
  }
  scene.decimals = Math.max(0, Math.round(-Math.log10(head.quantum)));
  scene.low = scene.drawn(bounds[0]);
  scene.high = scene.drawn(bounds[1]);
  // Where the die is, which a path's clearance may be far above.
  if (scene.elements.length) {
    scene.low = [Infinity, Infinity, Infinity];
    scene.high = [-Infinity, -Infinity, -Infinity];
    for (let k = 0; k < scene.positions.length; ++k) {
      const c = k % 3, value = scene.positions[k];
      if (value < scene.low[c]) scene.low[c] = value;
      if (value > scene.high[c]) scene.high[c] = value;
    }
  }
  // Of the surface itself, for its colours: not down to the floor.
  scene.heights = [Infinity, -Infinity];
  for (const element of scene.elements) {
    if (element.block && scene.elements.some((each) => !each.block)) continue;
    for (let v = element.firstVertex; v < element.firstVertex + element.vertices; ++v) {
      const z = scene.positions[3 * v + 2];
      if (z < scene.heights[0]) scene.heights[0] = z;
      if (z > scene.heights[1]) scene.heights[1] = z;
    }
  }
  scene.size = Math.hypot(...[0, 1, 2].map((k) => scene.high[k] - scene.low[k])) || 1;
  return scene;
}

// A length for people, with its unit.
export function lengthText(scene, value, digits = scene.decimals) {
  const text = value.toFixed(Math.min(digits, 9));
  return (Number(text) === 0 ? text.replace('-', '') : text.replace('-', '−')) + (scene.unit ? ' ' + shortUnit(scene) : '');
}
export function shortUnit(scene) { return scene.unit === 'inch' ? 'in' : scene.unit; }
