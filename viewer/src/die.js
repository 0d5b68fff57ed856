// The die's surface elements and its lines, as three.js draws them.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import {scaleTexture} from './colors.js';
import {occlusionTexture} from './occlusion.js';
import {strokeFragment, strokeVertex, surfaceFragment, surfaceVertex} from './shaders.js';

const kColorings = {element: 0, height: 1, slope: 2, deviation: 3, cut: 4};
const kUnknown = 1e31;

export function surfaceMaterial(shared, own) {
  return new THREE.ShaderMaterial({
    uniforms: {...shared, color: {value: new THREE.Color('#888')}, block: {value: 0}, dim: {value: 0}, glow: {value: 0},
               alpha: {value: 1}, occluded: {value: 1}, ...own},
    vertexShader: surfaceVertex, fragmentShader: surfaceFragment, side: THREE.DoubleSide,
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  });
}

// `ends`: x, y, z of both ends of every stroke, one stroke after the other; or, where they are a chain, of its points.
export function strokes(ends, {chain = false, kinds = null, ...uniforms}, shared) {
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array([-1, 0, 0, 1, 0, 0, -1, 1, 0, 1, 1, 0]), 3));
  geometry.setIndex([0, 1, 2, 2, 1, 3]);
  const buffer = new THREE.InstancedInterleavedBuffer(ends, chain ? 3 : 6);
  const count = chain ? ends.length / 3 - 1 : ends.length / 6;
  geometry.setAttribute('from', new THREE.InterleavedBufferAttribute(buffer, 3, 0));
  geometry.setAttribute('to', new THREE.InterleavedBufferAttribute(buffer, 3, 3));
  if (kinds) geometry.setAttribute('kind', new THREE.InstancedBufferAttribute(kinds, 1));
  geometry.maxInstancedCount = count;
  const material = new THREE.ShaderMaterial({
    uniforms: {screen: shared.screen, cut: shared.cut, width: {value: 1.5}, lift: {value: 2e-5}, alpha: {value: 1},
               color: {value: new THREE.Color('#000')}, color2: {value: new THREE.Color('#000')}, ...uniforms},
    vertexShader: strokeVertex, fragmentShader: strokeFragment, side: THREE.DoubleSide, transparent: true,
  });
  const mesh = new THREE.Mesh(geometry, material);
  mesh.frustumCulled = false;
  return mesh;
}

export class Die {
  constructor(scene, world, shared) {
    this.scene = scene;
    this.world = world;
    this.scales = {};
    const occlusion = scene.elements.length ? occlusionTexture(scene) : null;
    this.shared = {
      ...shared, coloring: {value: 0}, range: {value: new THREE.Vector2(0, 1)}, scale: {value: null},
      shade: {value: occlusion?.texture ?? null}, shadeBox: {value: occlusion?.box ?? new THREE.Vector4()},
      shadeCell: {value: occlusion?.cell ?? 1}, shadeReach: {value: occlusion?.reach ?? 1},
      bottom: {value: scene.low[2]}, span: {value: scene.high[2] - scene.low[2]},
      cutMap: {value: null}, cutBox: {value: new THREE.Vector4()},
    };
    this.shared.scale.value = this.scaleOf('height');
    this.makeElements();
    this.makeLines();
  }

  scaleOf(name) { return (this.scales[name] ??= scaleTexture(name)); }

  makeElements() {
    const {scene} = this;
    const positions = new THREE.BufferAttribute(scene.positions, 3);
    const normals = new THREE.BufferAttribute(scene.normals, 3, true);
    const middle = new THREE.Vector3(...[0, 1, 2].map((k) => (scene.low[k] + scene.high[k]) / 2));
    const sphere = new THREE.Sphere(middle, scene.size);
    this.meshes = scene.elements.map((element, k) => {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', positions);
      geometry.setAttribute('normal', normals);
      geometry.setIndex(new THREE.BufferAttribute(scene.indices.subarray(3 * element.firstTriangle, 3 * (element.firstTriangle + element.triangles)), 1));
      geometry.boundingSphere = sphere;
      const mesh = new THREE.Mesh(geometry, surfaceMaterial(this.shared, {
        color: {value: new THREE.Color(element.color)}, block: {value: element.block ? 1 : 0}, occluded: {value: element.block ? 0 : 1}, dim: {value: 0}, glow: {value: 0}}));
      mesh.userData.smooth = geometry;
      this.world.add(mesh);
      return mesh;
    });
  }

  makeLines() {
    const {scene} = this;
    this.lines = {};
    let curve = 0, point = 0;
    for (const [name, width, alpha] of [['crease', 1.1, 0.75], ['edge', 1.7, 0.9], ['jump', 1.7, 0.9], ['other', 1.1, 0.75]]) {
      const first = curve, begin = point;
      let segments = 0;
      for (; curve < first + scene.curves[name]; ++curve) {
        segments += scene.curveLengths[curve] - 1;
        point += scene.curveLengths[curve];
      }
      if (segments === 0) continue;
      const ends = new Float32Array(6 * segments);
      let at = begin, to = 0;
      for (let c = first; c < curve; ++c, ++at) {
        for (let k = 1; k < scene.curveLengths[c]; ++k, ++at, to += 6) ends.set(scene.curvePoints.subarray(3 * at, 3 * at + 6), to);
      }
      this.lines[name] = strokes(ends, {width: {value: width * this.shared.pixelRatio.value}, alpha: {value: alpha}, color: {value: new THREE.Color('#16202b')}}, this.shared);
      this.world.add(this.lines[name]);
    }
  }

  colorings() {
    const names = ['element', 'height', 'slope'];
    if (this.scene.deviations) names.push('deviation');
    if (this.scene.cut) names.push('cut');
    return this.scene.elements.length ? names : [];
  }

  // Ends of the scale in units of length, degrees for slopes.
  setColoring(name, range) {
    this.shared.coloring.value = kColorings[name];
    this.shared.range.value.set(range[0], range[1]);
    if (name !== 'element') this.shared.scale.value = this.scaleOf(name);
    if (name === 'deviation') this.makeFlat();
    if (name === 'cut') this.makeCutMap();
    for (const mesh of this.meshes) {
      mesh.geometry = name === 'deviation' ? mesh.userData.flat : mesh.userData.smooth;
    }
  }

  // A deviation belongs to a triangle, so every triangle gets corners of its own.
  makeFlat() {
    const {scene} = this;
    for (const [k, mesh] of this.meshes.entries()) {
      if (mesh.userData.flat) continue;
      const element = scene.elements[k], corners = 3 * element.triangles;
      const places = new Float32Array(3 * corners), normals = new Int16Array(3 * corners), offs = new Float32Array(corners);
      for (let i = 0; i < corners; ++i) {
        const v = 3 * scene.indices[3 * element.firstTriangle + i];
        for (let c = 0; c < 3; ++c) {
          places[3 * i + c] = scene.positions[v + c];
          normals[3 * i + c] = scene.normals[v + c];
        }
        const code = scene.deviations[element.firstTriangle + Math.floor(i / 3)];
        offs[i] = code === -32768 ? kUnknown : code * scene.deviation_step;
      }
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(places, 3));
      geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3, true));
      geometry.setAttribute('off', new THREE.BufferAttribute(offs, 1));
      geometry.boundingSphere = mesh.userData.smooth.boundingSphere;
      mesh.userData.flat = geometry;
    }
  }

  makeCutMap() {
    if (this.shared.cutMap.value) return;
    const {cut, cutHeights} = this.scene;
    const pixels = new Uint8Array(4 * cutHeights.length);
    for (let k = 0; k < cutHeights.length; ++k) {
      const code = cutHeights[k];
      pixels.set(cutColor(code, code * cut.step, cut), 4 * k);
    }
    const texture = new THREE.DataTexture(pixels, cut.columns, cut.rows, THREE.RGBAFormat);
    texture.minFilter = texture.magFilter = THREE.LinearFilter;
    texture.needsUpdate = true;
    this.shared.cutMap.value = texture;
    const low = this.scene.drawn([...cut.corner, 0]);
    this.shared.cutBox.value.set(low[0], low[1], 1 / (cut.columns * cut.pixel[0]), 1 / (cut.rows * cut.pixel[1]));
  }

  show(k, shown) {
    this.scene.elements[k].shown = shown;
    this.meshes[k].visible = shown;
  }

  // One element stands out, -1 none; `near` is under the pointer in the list.
  emphasize(selected, near) {
    for (const [k, mesh] of this.meshes.entries()) {
      mesh.material.uniforms.dim.value = selected >= 0 && k !== selected ? 1 : 0;
      mesh.material.uniforms.glow.value = k === near ? 0.28 : 0;
    }
  }
}

// The colours of verify --map: red where it is gouged, green to the limit, yellow to blue where more stays.
function cutColor(code, height, cut) {
  if (code === -32768) return [0, 0, 0, 0];
  if (code === 32767) return [13, 13, 64, 255];
  if (height < -cut.gouge_limit) return [217, 26, 31, 255];
  const good = [41, 158, 92], full = [217, 212, 64], much = [41, 82, 191];
  const limit = cut.limit || 1e-12;
  const [a, b, t] = height <= limit ? [good, full, Math.max(0, height) / limit] : [full, much, Math.min(1, (height - limit) / (4 * limit))];
  return [0, 1, 2].map((c) => a[c] + t * (b[c] - a[c])).concat(255);
}
