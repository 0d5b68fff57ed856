// Unpacks the arrays of viewer/packed_arrays.cpp.
// SPDX-License-Identifier: Apache-2.0

// The bytes of the page's body: base64, then zlib's format.
export async function inflated(text) {
  const coded = atob(text);
  const bytes = new Uint8Array(coded.length);
  for (let k = 0; k < coded.length; ++k) bytes[k] = coded.charCodeAt(k);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// One array of the head's `arrays`, components beside one another.
export function unpacked(bytes, entry) {
  const {at, count, components, planes} = entry;
  const size = count * components;
  const codes = new Int32Array(size);
  for (let plane = 0; plane < planes; ++plane) {
    let from = at + plane * size;
    const shift = 8 * plane;
    for (let c = 0; c < components; ++c) {
      for (let k = c; k < size; k += components) codes[k] |= bytes[from++] << shift;
    }
  }
  if (entry.code === 'index') {
    let next = 0;
    for (let k = 0; k < size; ++k) {
      codes[k] = next - codes[k];
      if (codes[k] === next) ++next;
    }
    return new Uint32Array(codes.buffer);
  }
  for (let k = 0; k < size; ++k) {
    const code = codes[k];
    const change = (code >>> 1) ^ -(code & 1);
    codes[k] = k < components ? change : (codes[k - components] + change) | 0;
  }
  return codes;
}

// Octahedron to unit vector, 16 bits a component.
export function unpackedNormals(octahedron) {
  const count = octahedron.length / 2;
  const normals = new Int16Array(3 * count);
  for (let k = 0; k < count; ++k) {
    let x = octahedron[2 * k] / 2047, y = octahedron[2 * k + 1] / 2047;
    const z = 1 - Math.abs(x) - Math.abs(y);
    if (z < 0) {
      const folded = (1 - Math.abs(y)) * (x < 0 ? -1 : 1);
      y = (1 - Math.abs(x)) * (y < 0 ? -1 : 1);
      x = folded;
    }
    const scale = 32767 / Math.sqrt(x * x + y * y + z * z);
    normals[3 * k] = Math.round(x * scale);
    normals[3 * k + 1] = Math.round(y * scale);
    normals[3 * k + 2] = Math.round(z * scale);
  }
  return normals;
}
