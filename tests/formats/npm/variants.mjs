// Writes a GLB anew as other programs would: quantized, compressed with meshopt or Draco, interleaved, sparse.
// usage: node variants.mjs FILE.glb FOLDER
// SPDX-License-Identifier: Apache-2.0
import { join } from 'node:path';
import { Document, NodeIO } from '@gltf-transform/core';
import { ALL_EXTENSIONS, EXTMeshoptCompression, KHRDracoMeshCompression } from '@gltf-transform/extensions';
import { quantize, reorder, sparse } from '@gltf-transform/functions';
import draco3d from 'draco3d';
import { MeshoptDecoder, MeshoptEncoder } from 'meshoptimizer';

const [source, folder] = process.argv.slice(2);
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({
  'draco3d.decoder': await draco3d.createDecoderModule(),
  'draco3d.encoder': await draco3d.createEncoderModule(),
  'meshopt.decoder': MeshoptDecoder,
  'meshopt.encoder': MeshoptEncoder,
});
await MeshoptEncoder.ready;
await MeshoptDecoder.ready;

const variants = {
  rewritten: async () => {},
  quantized: async (document) => document.transform(quantize({ quantizePosition: 16, quantizeNormal: 12 })),
  meshopt: async (document) => {
    await document.transform(reorder({ encoder: MeshoptEncoder }));
    document.createExtension(EXTMeshoptCompression).setRequired(true);
  },
  meshopt_filtered: async (document) => {
    await document.transform(reorder({ encoder: MeshoptEncoder }), quantize({ quantizePosition: 14 }));
    document
      .createExtension(EXTMeshoptCompression)
      .setRequired(true)
      .setEncoderOptions({ method: EXTMeshoptCompression.EncoderMethod.FILTER });
  },
  draco: async (document) => {
    document
      .createExtension(KHRDracoMeshCompression)
      .setRequired(true)
      .setEncoderOptions({ method: KHRDracoMeshCompression.EncoderMethod.EDGEBREAKER, quantizationBits: { POSITION: 16 }, quantizationVolume: 'scene' });
  },
  draco_sequential: async (document) => {
    document
      .createExtension(KHRDracoMeshCompression)
      .setRequired(true)
      .setEncoderOptions({ method: KHRDracoMeshCompression.EncoderMethod.SEQUENTIAL, quantizationBits: { POSITION: 16 }, quantizationVolume: 'scene' });
  },
  sparse: async (document) => {
    for (const accessor of document.getRoot().listAccessors()) {
      if (accessor.getType() === 'VEC3') accessor.setSparse(true);
    }
  },
};

for (const [name, change] of Object.entries(variants)) {
  const document = await io.read(source);
  await change(document);
  await io.write(join(folder, `variant_${name}.glb`), document);
}
