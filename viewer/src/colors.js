// Scales of colour, those of diesink preview.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';

const kScales = {
  height: ['#440154', '#472d7b', '#3b528b', '#2c728e', '#21918c', '#28ae80', '#5ec962', '#addc30', '#fde725'],
  slope: ['#fff7cf', '#fed976', '#fd8d3c', '#e31a1c', '#800026'],
  deviation: ['#2166ac', '#67a9cf', '#d1e5f0', '#f7f7f7', '#fddbc7', '#ef8a62', '#b2182b'],
  // What a cutter leaves: gouged, good up to the limit, more, much more.
  cut: ['#d91a1f', '#d91a1f', '#299e5c', '#d9d440', '#8a9a66', '#29529f'],
};

const rgbOf = (code) => [1, 3, 5].map((k) => parseInt(code.slice(k, k + 2), 16));

export function scalePixels(name, count = 256) {
  const stops = kScales[name].map(rgbOf);
  const pixels = new Uint8Array(4 * count);
  for (let k = 0; k < count; ++k) {
    const at = k / (count - 1) * (stops.length - 1);
    const i = Math.min(Math.floor(at), stops.length - 2);
    for (let c = 0; c < 3; ++c) pixels[4 * k + c] = stops[i][c] + (at - i) * (stops[i + 1][c] - stops[i][c]);
    pixels[4 * k + 3] = 255;
  }
  return pixels;
}

export function scaleTexture(name) {
  const texture = new THREE.DataTexture(scalePixels(name), 256, 1, THREE.RGBAFormat);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}
