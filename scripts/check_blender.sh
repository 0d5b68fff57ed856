#!/usr/bin/env bash
# Blender, without its window, reads the STL, OBJ, PLY and GLB that diesink writes, and diesink reads those that Blender
# writes: the same triangles, bounds and closed edges.
# usage: scripts/check_blender.sh [PART]   default: fixtures/parts/fig6.part; needs build/release/bin/diesink, or $DIESINK
# Blender 3.3 and later. Where there is none the script says so and ends with 0.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v blender >/dev/null; then
  echo "check_blender: skipped, there is no blender here (Debian package blender)"
  exit 0
fi
diesink=${DIESINK:-$PWD/build/release/bin/diesink}
[ -x "$diesink" ] || { echo "check_blender: $diesink is missing; build it first" >&2; exit 1; }
part=${1:-fixtures/parts/fig6.part}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

"$diesink" export "$part" --solid --tolerance 0.05 --quiet \
  -o "$scratch/ours.stl" -o "$scratch/ours.obj" -o "$scratch/ours.ply" -o "$scratch/ours.glb"
"$diesink" info "$scratch/ours.stl" --json >"$scratch/expected.json"

cat >"$scratch/both_ways.py" <<'PYTHON'
import json
import sys

import bmesh
import bpy
import numpy

# Debian 12's Blender 3.4 came with a glTF importer for an older numpy than Debian's.
for name, kind in {"bool": bool, "int": int, "float": float, "object": object}.items():
    if name not in vars(numpy):
        setattr(numpy, name, kind)

folder = sys.argv[sys.argv.index("--") + 1]
with open(folder + "/expected.json", encoding="utf-8") as told:
    expected = json.load(told)


def first_of(*ways):
    """The first operator this Blender has; which they are changed with 3.3 and 4.0."""
    for group, name, options in ways:
        if name in dir(getattr(bpy.ops, group)):
            return lambda path: getattr(getattr(bpy.ops, group), name)(filepath=path, **options)
    return None


IMPORT = {
    "stl": first_of(("wm", "stl_import", {}), ("import_mesh", "stl", {})),
    "ply": first_of(("wm", "ply_import", {}), ("import_mesh", "ply", {})),
    "obj": first_of(("wm", "obj_import", {"forward_axis": "Y", "up_axis": "Z"}),
                    ("import_scene", "obj", {"axis_forward": "Y", "axis_up": "Z"})),
    "glb": first_of(("import_scene", "gltf", {})),
}
EXPORT = {
    "stl": first_of(("wm", "stl_export", {}), ("export_mesh", "stl", {})),
    "ascii.stl": first_of(("wm", "stl_export", {"ascii_format": True}), ("export_mesh", "stl", {"ascii": True})),
    "ply": first_of(("wm", "ply_export", {}), ("export_mesh", "ply", {})),
    "ascii.ply": first_of(("wm", "ply_export", {"ascii_format": True}), ("export_mesh", "ply", {"use_ascii": True})),
    "obj": first_of(("wm", "obj_export", {"forward_axis": "Y", "up_axis": "Z"})),
    "glb": first_of(("export_scene", "gltf", {"export_format": "GLB"})),
    "gltf": first_of(("export_scene", "gltf", {"export_format": "GLTF_SEPARATE"})),
}


def shape_of_all(distance):
    """All objects of the file as one mesh; what the parts repeat meets within the distance."""
    whole = bmesh.new()
    for each in bpy.data.objects:
        if each.type == "MESH":
            each.data.transform(each.matrix_world)
            whole.from_mesh(each.data)
    bmesh.ops.remove_doubles(whole, verts=whole.verts, dist=distance)
    return whole


failed = False
kept = None
for kind in IMPORT:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if IMPORT[kind] is None:
        print(f"check_blender: {kind}: skipped, this Blender has no importer")
        continue
    IMPORT[kind](f"{folder}/ours.{kind}")
    # glTF is in metres, everything else in the part's millimetres.
    scale = 1e-3 if kind == "glb" else 1
    bounds = [scale * x for x in sum(expected["bounds"], [])]
    size = max(b - a for a, b in zip(bounds[:3], bounds[3:]))
    # glTF alone repeats vertices, at creases; Blender turns them by a product that rounds equal ones apart.
    whole = shape_of_all(1e-6 * size if kind == "glb" else 0)
    low = [min(v.co[i] for v in whole.verts) for i in range(3)]
    high = [max(v.co[i] for v in whole.verts) for i in range(3)]
    off = max(abs(a - b) for a, b in zip(low + high, bounds))
    closed = all(len(edge.link_faces) == 2 for edge in whole.edges)
    same = len(whole.faces) == expected["triangles"] and off <= 1e-6 * size and closed == expected["watertight"]
    print(f"check_blender: reads {kind}: {len(whole.faces)} of {expected['triangles']} triangles, "
          f"bounds off by {off:.3g}, closed {closed} of {expected['watertight']}: {'same' if same else 'DIFFERENT'}")
    failed = failed or not same
    if kind == "stl":
        kept = ([v.co[:] for v in whole.verts], [[v.index for v in f.verts] for f in whole.faces])
    whole.free()
for kind in EXPORT:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    mesh = bpy.data.meshes.new("die")
    mesh.from_pydata(kept[0], [], kept[1])
    item = bpy.data.objects.new("die", mesh)
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    item.select_set(True)
    if EXPORT[kind] is None:
        print(f"check_blender: {kind}: skipped, this Blender has no exporter")
    else:
        EXPORT[kind](f"{folder}/theirs.{kind}")
if failed:
    raise SystemExit(1)
PYTHON
blender --background --factory-startup --python-exit-code 1 --python "$scratch/both_ways.py" -- "$scratch" >"$scratch/log" 2>&1 ||
  { grep "^check_blender:" "$scratch/log"; tail -n 5 "$scratch/log"; exit 1; }
grep '^check_blender:' "$scratch/log"

status=0
for file in "$scratch"/theirs.*; do
  case "$file" in *.bin | *.mtl) continue ;; esac
  "$diesink" info "$file" --json >"$file.json" 2>"$file.told" || { cat "$file.told"; status=1; continue; }
  python3 - "$file" "$scratch/expected.json" <<'PYTHON' || status=1
import json
import sys

path, expected_path = sys.argv[1:]
with open(path + ".json", encoding="utf-8") as told:
    seen = json.load(told)
with open(expected_path, encoding="utf-8") as told:
    expected = json.load(told)
low, high = expected["bounds"]
if path.endswith(("glb", "gltf")):
    # Y up: x stays, y is the old z, z the old -y. Blender takes its lengths for metres.
    low, high = [low[0], low[2], -high[1]], [high[0], high[2], -low[1]]
size = max(b - a for a, b in zip(low, high))
off = max(abs(a - b) for a, b in zip(sum(seen["bounds"], []), low + high))
same = (seen["triangles"] == expected["triangles"] and off <= 1e-6 * size
        and seen["watertight"] == expected["watertight"])
print(f"check_blender: writes {path.split('theirs.')[1]}: {seen['triangles']} of {expected['triangles']} triangles, "
      f"bounds off by {off:.3g}, closed {seen['watertight']} of {expected['watertight']}: "
      f"{'same' if same else 'DIFFERENT'}")
sys.exit(0 if same else 1)
PYTHON
done
exit $status
