// Reads glTF and GLB files with the Khronos validator and with glTF-Transform (draco3d, meshoptimizer).
// Prints a JSON object a file, one a line: what each reader saw. Exit status 1 where one complains.
// usage: node validate.mjs FILE...
// SPDX-License-Identifier: Apache-2.0
import { readFile } from 'node:fs/promises';
import { basename, dirname, join } from 'node:path';
import { createRequire } from 'node:module';
import { NodeIO, Primitive } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import draco3d from 'draco3d';
import { MeshoptDecoder } from 'meshoptimizer';

const validator = createRequire(import.meta.url)('gltf-validator');

const io = new NodeIO()
  .registerExtensions(ALL_EXTENSIONS)
  .registerDependencies({ 'draco3d.decoder': await draco3d.createDecoderModule(), 'meshopt.decoder': MeshoptDecoder });

async function validated(file) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    uri: basename(file),
    maxIssues: 20,
    externalResourceFunction: async (uri) => new Uint8Array(await readFile(join(dirname(file), decodeURIComponent(uri)))),
  });
  const messages = report.issues.messages.filter((m) => m.severity <= 1);
  return {
    errors: report.issues.numErrors,
    warnings: report.issues.numWarnings,
    messages: messages.map((m) => `${m.code} ${m.pointer ?? ''} ${m.message}`),
    triangles: report.info?.totalTriangleCount,
  };
}

// World coordinates of every triangle corner, so that two files can be compared as geometry.
async function transformed(file) {
  const document = await io.read(file);
  const root = document.getRoot();
  const seen = { triangles: 0, lines: 0, primitives: [], extras: root.getAsset().extras ?? null, low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity], sums: [0, 0, 0] };
  for (const node of root.listNodes()) {
    const mesh = node.getMesh();
    if (!mesh) continue;
    const m = node.getWorldMatrix();
    for (const primitive of mesh.listPrimitives()) {
      const position = primitive.getAttribute('POSITION');
      const indices = primitive.getIndices();
      const count = indices ? indices.getCount() : position.getCount();
      const p = [];
      for (let i = 0; i < count; ++i) {
        position.getElement(indices ? indices.getScalar(i) : i, p);
        for (let k = 0; k < 3; ++k) {
          const w = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
          seen.low[k] = Math.min(seen.low[k], w);
          seen.high[k] = Math.max(seen.high[k], w);
          if (primitive.getMode() === Primitive.Mode.TRIANGLES) seen.sums[k] += w;
        }
      }
      if (primitive.getMode() === Primitive.Mode.TRIANGLES) seen.triangles += count / 3;
      else seen.lines += count / 2;
      const element = primitive.getAttribute('_ELEMENT');
      seen.primitives.push({
        name: primitive.getMaterial()?.getName() ?? null,
        count,
        vertices: position.getCount(),
        normals: !!primitive.getAttribute('NORMAL'),
        element: element ? element.getScalar(0) : null,
      });
    }
  }
  return seen;
}

let bad = 0;
for (const file of process.argv.slice(2)) {
  const line = { file: basename(file) };
  try {
    line.validator = await validated(file);
    line.transform = await transformed(file);
    if (line.validator.errors + line.validator.warnings > 0) bad = 1;
  } catch (error) {
    line.failure = String(error);
    bad = 1;
  }
  console.log(JSON.stringify(line));
}
process.exit(bad);
