// The tool path: its moves, and the cutter at a place along it.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import {strokes, surfaceMaterial} from './die.js';

const kSecondsAtOne = 120;  // for the whole path, at speed ×1

// The cutter turned about its axis: flat end, corner, shank; the tip at the origin.
function cutterGeometry(cutter, height) {
  const radius = cutter.diameter / 2, corner = Math.min(cutter.corner_radius, radius), flat = radius - corner;
  const profile = [new THREE.Vector2(0, 0)];
  if (flat > 0) profile.push(new THREE.Vector2(flat, 0));
  if (corner > 0) {
    for (let k = 1; k <= 16; ++k) {
      const angle = k / 16 * Math.PI / 2;
      profile.push(new THREE.Vector2(flat + corner * Math.sin(angle), corner * (1 - Math.cos(angle))));
    }
  }
  profile.push(new THREE.Vector2(radius, height), new THREE.Vector2(0, height));
  return new THREE.LatheBufferGeometry(profile, 48).rotateX(Math.PI / 2);
}

export class Path {
  constructor(scene, world, shared, dieShared) {
    this.scene = scene;
    const {pathPoints: p, pathRapid} = scene;
    this.count = p.length / 3;
    this.lengths = new Float64Array(this.count);
    for (let k = 1; k < this.count; ++k) {
      this.lengths[k] = this.lengths[k - 1] + Math.hypot(p[3 * k] - p[3 * k - 3], p[3 * k + 1] - p[3 * k - 2], p[3 * k + 2] - p[3 * k - 1]);
    }
    this.total = this.lengths[this.count - 1] || 1;
    const kinds = new Float32Array(Math.max(1, this.count - 1));
    for (let k = 1; k < this.count; ++k) kinds[k - 1] = pathRapid[k];
    const look = {chain: true, kinds, color: {value: new THREE.Color('#0f62c4')}, color2: {value: new THREE.Color('#d4380d')}, lift: {value: 3e-5}};
    this.done = strokes(p, {...look, width: {value: 1.6 * shared.pixelRatio.value}}, shared);
    this.ahead = strokes(p, {...look, width: {value: 1.0 * shared.pixelRatio.value}, alpha: {value: 0.16}}, shared);
    world.add(this.done, this.ahead);
    this.cutter = new THREE.Object3D();
    if (scene.cutter && scene.cutter.diameter > 0) {
      const height = Math.max(2.2 * scene.cutter.diameter, 0.22 * scene.size);
      const material = surfaceMaterial({...dieShared, cut: {value: new THREE.Vector4(0, 0, 0, 1)}, coloring: {value: 0}},
        {color: {value: new THREE.Color('#dfe4ea')}, occluded: {value: 0}, alpha: {value: 0.78}});
      material.transparent = true;
      material.side = THREE.FrontSide;
      this.cutter = new THREE.Mesh(cutterGeometry(scene.cutter, height), material);
      this.cutter.renderOrder = 5;
      this.cutter.frustumCulled = false;
    }
    world.add(this.cutter);
    // It would cover the colours of what it leaves.
    this.show('path', scene.coloring !== 'cut');
    this.set(1);
  }

  // The last point at or before a length along the path.
  pointBefore(length) {
    let low = 0, high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.lengths[middle] <= length) low = middle; else high = middle - 1;
    }
    return low;
  }

  // part: 0..1 of the path's length.
  set(part) {
    this.place = Math.min(1, Math.max(0, part));
    const length = this.place * this.total;
    this.at = this.pointBefore(length);
    const next = Math.min(this.at + 1, this.count - 1);
    const step = this.lengths[next] - this.lengths[this.at];
    const t = step > 0 ? (length - this.lengths[this.at]) / step : 0;
    const {pathPoints: p} = this.scene;
    this.tip = [0, 1, 2].map((c) => p[3 * this.at + c] + t * (p[3 * next + c] - p[3 * this.at + c]));
    this.rapid = this.scene.pathRapid[t > 0 ? next : this.at] === 1;
    this.cutter.position.set(...this.tip);
    this.done.geometry.maxInstancedCount = t > 0 ? next : this.at;
  }

  step(by) {
    const k = by < 0 && this.lengths[this.at] < this.place * this.total - 1e-12 * this.total ? this.at : this.at + by;
    this.set(this.lengths[Math.min(this.count - 1, Math.max(0, k))] / this.total);
  }

  advance(seconds, speed) { this.set(this.place + seconds * speed / kSecondsAtOne); }

  show(what, shown) {
    if (what === 'cutter') this.cutter.visible = shown;
    if (what === 'path') this.done.visible = this.ahead.visible = shown;
    if (what === 'rest') this.ahead.material.visible = shown;
  }
}
