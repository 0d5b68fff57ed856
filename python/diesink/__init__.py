"""Compound surfaces for dies: part programs evaluated, tessellated, cut and verified.

    import diesink
    part = diesink.load("fixtures/parts/fig6.part")
    data = part.evaluate([20.0, 30.0], [20.0, 25.0])     # z, normals, element ids
    mesh = part.tessellate(tolerance=0.01)               # vertices, triangles, element ids
    part.export("fig6.stl", "fig6.glb")
    path = part.cl(cutter=(6, 3), cusp=0.01)             # tips, rapid or feed
    path.write("fig6.ngc")
    check = part.verify(path)                            # gouge, excess, cusps

Lengths are in the part program's unit, Z is up, arrays are numpy's. Long work runs on all cores and
without the interpreter's lock. What is wrong with a file is a diesink.Error that carries every
message with its place.
"""
# SPDX-License-Identifier: Apache-2.0
from ._diesink import (CcData, Curve, Diagnostic, Error, Mesh, Part, ToolPath, Verification, __version__, formats, load,
                       parse, read_mesh, read_path)

__all__ = ["CcData", "Curve", "Diagnostic", "Error", "Mesh", "Part", "ToolPath", "Verification", "__version__", "formats",
           "load", "parse", "read_mesh", "read_path"]
