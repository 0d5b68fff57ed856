// SPDX-License-Identifier: Apache-2.0
#include "formats/written_mesh.h"

#include "formats/byte_sink.h"

namespace diesink {

Result<WrittenMesh> write_to_memory(decltype(Format::stream) stream, const TriangleMesh& mesh,
                                    const WriteOptions& options) {
  MemoryFiles files;
  Result<WrittenMesh> written = stream(mesh, options, files);
  if (written) written->files = files.take();
  return written;
}

}  // namespace diesink
