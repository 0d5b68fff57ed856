// How much of the sky each place of the die sees: light is less in hollows and at the foot of walls.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';

const kCells = 320;                           // along the longer side
const kDirections = 16, kSteps = [1, 2, 3, 4.5, 6.5, 9, 12, 16];

// Highest point of the mesh over the middle of each cell; -Infinity where there is none.
function topHeights(scene, columns, rows, cell) {
  const heights = new Float32Array(columns * rows).fill(-Infinity);
  const {positions: p, indices, low} = scene;
  for (let t = 0; t < indices.length; t += 3) {
    const a = 3 * indices[t], b = 3 * indices[t + 1], c = 3 * indices[t + 2];
    const ax = (p[a] - low[0]) / cell - 0.5, ay = (p[a + 1] - low[1]) / cell - 0.5;
    const bx = (p[b] - low[0]) / cell - 0.5, by = (p[b + 1] - low[1]) / cell - 0.5;
    const cx = (p[c] - low[0]) / cell - 0.5, cy = (p[c + 1] - low[1]) / cell - 0.5;
    const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    if (Math.abs(area) < 1e-9) continue;
    const x0 = Math.max(0, Math.ceil(Math.min(ax, bx, cx))), x1 = Math.min(columns - 1, Math.floor(Math.max(ax, bx, cx)));
    const y0 = Math.max(0, Math.ceil(Math.min(ay, by, cy))), y1 = Math.min(rows - 1, Math.floor(Math.max(ay, by, cy)));
    for (let y = y0; y <= y1; ++y) {
      for (let x = x0; x <= x1; ++x) {
        const v = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area;
        const w = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area;
        if (v < 0 || w < 0 || v + w > 1) continue;
        const z = p[a + 2] + v * (p[b + 2] - p[a + 2]) + w * (p[c + 2] - p[a + 2]);
        if (z > heights[y * columns + x]) heights[y * columns + x] = z;
      }
    }
  }
  return heights;
}

// The mean of each cell and its eight neighbours: a finite number of directions leaves rings.
function blurred(values, columns, rows) {
  const result = new Float32Array(values.length);
  for (let y = 0; y < rows; ++y) {
    for (let x = 0; x < columns; ++x) {
      let sum = 0, count = 0;
      for (let j = Math.max(0, y - 1); j <= Math.min(rows - 1, y + 1); ++j) {
        for (let i = Math.max(0, x - 1); i <= Math.min(columns - 1, x + 1); ++i, ++count) sum += values[j * columns + i];
      }
      result[y * columns + x] = sum / count;
    }
  }
  return result;
}

// A texture over the die's plan: red is the part of the sky that is seen, green the height, both 0..1.
export function occlusionTexture(scene) {
  const {low, high} = scene;
  const cell = Math.max(high[0] - low[0], high[1] - low[1]) / kCells || 1;
  const columns = Math.max(1, Math.ceil((high[0] - low[0]) / cell)), rows = Math.max(1, Math.ceil((high[1] - low[1]) / cell));
  const heights = topHeights(scene, columns, rows, cell);
  const ground = (k) => (heights[k] === -Infinity ? low[2] : heights[k]);
  const around = [];
  for (let d = 0; d < kDirections; ++d) {
    const angle = 2 * Math.PI * (d + 0.5) / kDirections;
    around.push(kSteps.map((step) => [Math.round(step * Math.cos(angle)), Math.round(step * Math.sin(angle))])
      .map(([dx, dy]) => [dx, dy, Math.hypot(dx, dy) * cell]));
  }
  const seenAt = new Float32Array(columns * rows);
  const span = high[2] - low[2] || 1;
  for (let y = 0, k = 0; y < rows; ++y) {
    for (let x = 0; x < columns; ++x, ++k) {
      const z = ground(k);
      let seen = 0;
      for (const steps of around) {
        let steepest = 0;
        for (const [dx, dy, length] of steps) {
          const i = x + dx, j = y + dy;
          if (i < 0 || j < 0 || i >= columns || j >= rows) break;
          // A plane that slopes hides nothing of its own sky: what counts is how far it bends upward.
          const bi = x - dx, bj = y - dy;
          const rise = ground(j * columns + i) - z;
          const back = bi < 0 || bj < 0 || bi >= columns || bj >= rows ? 0 : z - ground(bj * columns + bi);
          const bend = rise - Math.max(0, Math.min(rise, back));
          if (bend > steepest * length) steepest = bend / length;
        }
        seen += 1 - steepest / Math.sqrt(1 + steepest * steepest);
      }
      seenAt[k] = seen / kDirections;
    }
  }
  const smooth = blurred(blurred(seenAt, columns, rows), columns, rows);
  const pixels = new Uint8Array(4 * columns * rows);
  for (let k = 0; k < columns * rows; ++k) {
    pixels[4 * k] = Math.round(255 * smooth[k]);
    pixels[4 * k + 1] = Math.round(255 * (ground(k) - low[2]) / span);
    pixels[4 * k + 3] = 255;
  }
  const texture = new THREE.DataTexture(pixels, columns, rows, THREE.RGBAFormat);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return {texture, box: new THREE.Vector4(low[0], low[1], 1 / (columns * cell), 1 / (rows * cell)), cell, reach: 14 * cell};
}
