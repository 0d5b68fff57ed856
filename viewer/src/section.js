// A plane that cuts the die open: the cut is hatched where the mesh is closed, its outline drawn.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import {strokes} from './die.js';
import {capFragment, capVertex} from './shaders.js';

// The ends of the mesh's stretches in the plane `axis` = `at`, and whether they close to outlines.
export function outline(scene, axis, at) {
  const {positions: p, indices} = scene;
  const ends = [];
  const odd = new Set();
  // The same edge gives the same point in both of its triangles: its ends are taken in one order.
  const cross = (a, b) => {
    let i = 3 * a, j = 3 * b;
    for (let c = 0; c < 3; ++c) {
      if (p[i + c] === p[j + c]) continue;
      if (p[i + c] > p[j + c]) [i, j] = [j, i];
      break;
    }
    const t = (at - p[i + axis]) / (p[j + axis] - p[i + axis]);
    const point = [0, 1, 2].map((c) => Math.fround(p[i + c] + t * (p[j + c] - p[i + c])));
    point[axis] = at;
    const key = [0, 1, 2].map((c) => p[i + c] + ' ' + p[j + c]).join(' ');
    if (!odd.delete(key)) odd.add(key);
    return point;
  };
  for (let t = 0; t < indices.length; t += 3) {
    const a = indices[t], b = indices[t + 1], c = indices[t + 2];
    const sa = p[3 * a + axis] >= at, sb = p[3 * b + axis] >= at, sc = p[3 * c + axis] >= at;
    if (sa === sb && sb === sc) continue;
    // The corner that is alone on its side.
    const [alone, q, r] = sa === sb ? [c, a, b] : sb === sc ? [a, b, c] : [b, c, a];
    ends.push(...cross(alone, q), ...cross(alone, r));
  }
  return {ends: new Float32Array(ends), closed: odd.size === 0};
}

export class Section {
  constructor(scene, world, shared, pitch) {
    this.scene = scene;
    this.world = world;
    this.shared = shared;
    this.axis = -1;
    this.side = 1;
    this.parts = [];
    this.pitch = pitch;
    this.color = new THREE.Color('#c9ced4');
    this.ink = new THREE.Color('#4a5560');
    shared.cut.value.set(0, 0, 0, 1);
  }

  // axis -1: no section. `at` counts in the scene's drawn places; what lies beyond it on `side` goes.
  set(axis, at, side) {
    Object.assign(this, {axis, at, side});
    for (const each of this.parts) {
      this.world.remove(each);
      each.geometry.dispose();
      each.material.dispose();
    }
    this.parts = [];
    if (axis < 0) {
      this.shared.cut.value.set(0, 0, 0, 1);
      return;
    }
    // A hair of room keeps the lines that lie in the plane.
    const room = 1e-6 * this.scene.size;
    const normal = [0, 0, 0];
    normal[axis] = side;
    this.shared.cut.value.set(...normal, side * at + room);
    const {ends, closed} = outline(this.scene, axis, at);
    if (ends.length === 0) return;
    if (closed) this.fill(ends);
    const line = strokes(ends, {width: {value: 2.2 * this.shared.pixelRatio.value}, lift: {value: 6e-5}, color: {value: new THREE.Color('#c2410c')}}, this.shared);
    this.add(line, 3);
  }

  stays(x, y, z) { return this.axis < 0 || this.side * ([x, y, z][this.axis] - this.at) <= 1e-6 * this.scene.size; }

  add(mesh, order) {
    mesh.renderOrder = order;
    mesh.frustumCulled = false;
    this.world.add(mesh);
    this.parts.push(mesh);
  }

  // Triangles from one point to every stretch turn the stencil over: it is odd inside the outline.
  fill(ends) {
    const {low, high} = this.scene;
    const fan = new Float32Array(ends.length / 6 * 9);
    for (let k = 0; k < ends.length / 6; ++k) {
      fan.set(ends.subarray(0, 3), 9 * k);
      fan.set(ends.subarray(6 * k, 6 * k + 6), 9 * k + 3);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(fan, 3));
    const stencil = new THREE.ShaderMaterial({vertexShader: capVertex, fragmentShader: 'void main() { gl_FragColor = vec4(0.0); }', side: THREE.DoubleSide,
      depthTest: false, depthWrite: false, colorWrite: false});
    Object.assign(stencil, {stencilWrite: true, stencilFunc: THREE.AlwaysStencilFunc, stencilFail: THREE.InvertStencilOp,
      stencilZFail: THREE.InvertStencilOp, stencilZPass: THREE.InvertStencilOp});
    this.add(new THREE.Mesh(geometry, stencil), 1);

    const [u, v] = [0, 1, 2].filter((k) => k !== this.axis);
    const corner = (a, b) => {
      const p = [0, 0, 0];
      p[this.axis] = this.at;
      p[u] = a ? high[u] : low[u];
      p[v] = b ? high[v] : low[v];
      return p;
    };
    const sheet = new THREE.BufferGeometry();
    sheet.setAttribute('position', new THREE.BufferAttribute(new Float32Array([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 0), corner(1, 1), corner(0, 1)].flat()), 3));
    const across = new THREE.Vector3();
    // Upright in the usual view, for either upright plane.
    across.setComponent(u, Math.SQRT1_2).setComponent(v, this.axis === 1 ? Math.SQRT1_2 : -Math.SQRT1_2);
    const hatch = new THREE.ShaderMaterial({uniforms: {color: {value: this.color}, ink: {value: this.ink}, across: {value: across}, pitch: this.pitch},
      vertexShader: capVertex, fragmentShader: capFragment, side: THREE.DoubleSide, extensions: {derivatives: true}});
    Object.assign(hatch, {stencilWrite: true, stencilRef: 0, stencilFunc: THREE.NotEqualStencilFunc, stencilZPass: THREE.KeepStencilOp,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1});
    this.add(new THREE.Mesh(sheet, hatch), 2);
  }
}
