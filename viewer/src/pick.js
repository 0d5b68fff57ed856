// What lies under the pointer.
// SPDX-License-Identifier: Apache-2.0

const kSnapPixels = 11;

// The nearest shown triangle along a line of sight: {element, triangle, point, along}, or null. `stays(x, y, z)` tells what a section leaves.
export function hit(scene, ray, stays) {
  const {positions: p, indices} = scene;
  const {x: ox, y: oy, z: oz} = ray.origin, {x: dx, y: dy, z: dz} = ray.direction;
  let best = null, nearest = Infinity;
  for (const [number, element] of scene.elements.entries()) {
    if (!element.shown) continue;
    const end = 3 * (element.firstTriangle + element.triangles);
    for (let t = 3 * element.firstTriangle; t < end; t += 3) {
      const a = 3 * indices[t], b = 3 * indices[t + 1], c = 3 * indices[t + 2];
      const ax = p[a], ay = p[a + 1], az = p[a + 2];
      const ux = p[b] - ax, uy = p[b + 1] - ay, uz = p[b + 2] - az;
      const vx = p[c] - ax, vy = p[c + 1] - ay, vz = p[c + 2] - az;
      const px = dy * vz - dz * vy, py = dz * vx - dx * vz, pz = dx * vy - dy * vx;
      const determinant = ux * px + uy * py + uz * pz;
      if (determinant === 0) continue;
      const sx = ox - ax, sy = oy - ay, sz = oz - az;
      const u = (sx * px + sy * py + sz * pz) / determinant;
      if (u < 0 || u > 1) continue;
      const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
      const v = (dx * qx + dy * qy + dz * qz) / determinant;
      if (v < 0 || u + v > 1) continue;
      const along = (vx * qx + vy * qy + vz * qz) / determinant;
      if (!(along > 0 && along < nearest)) continue;
      const point = [ox + along * dx, oy + along * dy, oz + along * dz];
      if (!stays(...point)) continue;
      nearest = along;
      best = {element: number, triangle: t / 3, point, along};
    }
  }
  return best;
}

// The vertex within some pixels of (x, y) that can be seen, first those of the lines, then those of the triangle that was hit; else the hit itself.
export function snapped(scene, eye, x, y, found, stays) {
  const {low, high} = scene;
  const slack = 2e-3 * Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  const depth = found ? eye.project(found.point)[2] - slack : -Infinity;
  let best = null, nearest = kSnapPixels * kSnapPixels;
  const consider = (places, k) => {
    const place = [places[k], places[k + 1], places[k + 2]];
    const [px, py, toward] = eye.project(place);
    const away = (px - x) * (px - x) + (py - y) * (py - y);
    if (away >= nearest || toward < depth - Math.sqrt(away) * eye.unitsPerPixel * 3 || !stays(...place)) return;
    nearest = away;
    best = place;
  };
  for (let k = 0; k < scene.curvePoints.length; k += 3) consider(scene.curvePoints, k);
  if (!best && found) {
    for (let c = 0; c < 3; ++c) consider(scene.positions, 3 * scene.indices[3 * found.triangle + c]);
  }
  if (best) return {point: scene.own(best), drawn: best, vertex: true, element: found ? found.element : -1};
  if (!found) return null;
  const middle = scene.own([0, 0, 0]);
  return {point: found.point.map((value, k) => value + middle[k]), drawn: found.point, vertex: false, element: found.element};
}
