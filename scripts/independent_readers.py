#!/usr/bin/env python3
"""Meshes of four kinds, written in every format, read by programs that are not ours; prints what each makes of them as a table.

usage: scripts/independent_readers.py [BUILD]     default: build/release, with its targets diesink and foreign_readers
Readers: assimp and OpenMesh (by foreign_readers), Blender, and gltf-validator and glTF-Transform (where npm ci was run in
tests/formats/npm). One that is not here is left out, and said so. Exit status 1 where one reads something else.
"""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FORMS = {  # name: ending, options
    "STL": ("stl", []), "STL ASCII": ("ascii.stl", ["--ascii"]), "OBJ": ("obj", []), "PLY": ("ply", []),
    "PLY ASCII": ("ascii.ply", ["--ascii"]), "OFF": ("off", []), "glTF": ("gltf", []), "GLB": ("glb", []),
    "GLB Draco": ("draco.glb", ["--draco"]),
}
# With names, colours of elements and vertices, normals and a line.
COLOURED = """# units: mm
# up: z
mtllib coloured.mtl
v 0 0 0 1 0 0
v 20 0 0 0 1 0
v 20 12 0 0 0 1
v 0 12 0 1 1 0
v 10 6 7.25 1 1 1
vn 0 0 -1
vn 0 -0.77 0.638
vn 0.59 0 0.807
vn 0 0.77 0.638
vn -0.59 0 0.807
g S1.floor
usemtl S1
f 1//1 3//1 2//1
f 1//1 4//1 3//1
g S2.side
usemtl S2
f 1//2 2//2 5//2
f 2//3 3//3 5//3
g S2.top
f 3//4 4//4 5//4
f 4//5 1//5 5//5
g crease:S1.floor|S2.side
l 1 2 3 4 1
"""
MATERIALS = "newmtl S1\nKd 0.2 0.4 0.8\nnewmtl S2\nKd 0.9 0.1 0.1\nd 0.5\n"
SCANNED = """SOLID-DEF
S1,SPHER
P1,50,30,4
RAD,9
BSURF-DEF
MESH,scan.stl
BOOLE-DEF
B+S1
MACHI-DEF
TOLER,.05
"""
IN_BLENDER = r"""
import json, sys
import bmesh, bpy, numpy
for name, kind in {"bool": bool, "int": int, "float": float, "object": object}.items():
    if name not in vars(numpy):
        setattr(numpy, name, kind)
def read(path):
    ending = path.rsplit(".", 1)[1]
    if ending in ("glb", "gltf"):
        bpy.ops.import_scene.gltf(filepath=path)
    elif ending == "obj":
        bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z")
    elif ending + "_import" in dir(bpy.ops.wm):
        getattr(bpy.ops.wm, ending + "_import")(filepath=path)
    else:
        getattr(bpy.ops.import_mesh, ending)(filepath=path)
for path in sys.argv[sys.argv.index("--") + 1:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    told = {"reader": "Blender", "file": path}
    try:
        read(path)
        whole = bmesh.new()
        for each in bpy.data.objects:
            if each.type == "MESH":
                each.data.transform(each.matrix_world)
                whole.from_mesh(each.data)
        low = [min(v.co[i] for v in whole.verts) for i in range(3)]
        high = [max(v.co[i] for v in whole.verts) for i in range(3)]
        near = 1e-6 * max(b - a for a, b in zip(low, high)) if path.endswith(("glb", "gltf")) else 0
        bmesh.ops.remove_doubles(whole, verts=whole.verts, dist=near)
        told.update(triangles=len(whole.faces), bounds=low + high,
                    watertight=all(len(e.link_faces) == 2 for e in whole.edges if e.link_faces))
    except Exception as error:
        told["failure"] = str(error)
    print("TOLD " + json.dumps(told), flush=True)
"""


def run(*words, **options):
    return subprocess.run([str(w) for w in words], capture_output=True, text=True, check=False, **options)


def write_all(diesink, folder):
    """The files of every case, and what they hold by our own reading of the PLY."""
    (folder / "coloured.obj").write_text(COLOURED)
    (folder / "coloured.mtl").write_text(MATERIALS)
    run(sys.executable, ROOT / "scripts/make_scan.py", "--plain", folder / "scan.stl")
    (folder / "scan.part").write_text(SCANNED)
    cases = {"fig6": ("export", ROOT / "fixtures/parts/fig6.part", "--solid"),
             "coloured": ("convert", folder / "coloured.obj"),
             "scan": ("export", folder / "scan.part", "--solid"),
             "pockets": ("export", ROOT / "fixtures/parts/pockets.part", "--solid")}
    files = {}
    for case, (command, what, *more) in cases.items():
        made = folder / f"{case}.made.ply"
        options = [*more, "--tolerance", "0.05", "--lines"] if command == "export" else []
        done = run(diesink, command, what, *(["-o"] if command == "export" else []), made, *options, "--quiet")
        if not made.exists():
            sys.exit(f"independent_readers: {case}: {done.stderr}")
        expected = json.loads(run(diesink, "info", made, "--json", "--quiet").stdout)
        for form, (ending, options) in FORMS.items():
            path = folder / f"{case}.{ending}"
            done = run(diesink, "convert", made, path, *options, "--units-in", "mm", "--up-in", "z", "--quiet")
            if done.returncode != 0:
                sys.exit(f"independent_readers: {path.name}: {done.stderr}")
            files[str(path)] = (case, form, expected)
    return files


def verdict(told, expected, form):
    """Empty where the reader saw the same."""
    if "failure" in told or "triangles" not in told:
        return "not read"
    low, high = expected["bounds"]
    if form.startswith("G") or form == "glTF":
        if told["reader"] != "Blender":  # which turns Z up again
            low, high = [low[0], low[2], -high[1]], [high[0], high[2], -low[1]]
        low, high = [1e-3 * x for x in low], [1e-3 * x for x in high]
    size = max(b - a for a, b in zip(low, high))
    off = max(abs(a - b) for a, b in zip(told["bounds"], low + high)) / size
    wrong = []
    if told["triangles"] != expected["triangles"]:
        wrong.append(f"{told['triangles']} triangles")
    if off > (1e-3 if "Draco" in form else 2e-6):
        wrong.append(f"bounds off by {off:.1e}")
    if told.get("watertight", expected["watertight"]) != expected["watertight"]:
        wrong.append("closed" if told["watertight"] else "open")
    return ", ".join(wrong + told.get("messages", []))


def readings(build, folder, files):
    paths = list(files)
    foreign = build / "bin/foreign_readers"
    lines = []
    if foreign.exists():
        lines += run(foreign, *paths).stdout.splitlines()
    else:
        print("independent_readers: no foreign_readers, so no assimp and no OpenMesh")
    if shutil.which("blender"):
        (folder / "read.py").write_text(IN_BLENDER)
        # Debian's Blender takes the modules of the first python3 it finds.
        path = "/usr/bin:/bin:" + os.environ.get("PATH", "")
        done = run("blender", "--background", "--factory-startup", "--python", folder / "read.py", "--",
                   *[p for p in paths if not p.endswith((".off", ".draco.glb"))],
                   env={**os.environ, "PATH": path})
        if "TOLD " not in done.stdout:
            sys.exit("independent_readers: Blender read nothing: " + done.stdout[-500:])
        lines += [line[5:] for line in done.stdout.splitlines() if line.startswith("TOLD ")]
    else:
        print("independent_readers: no Blender")
    told = [json.loads(line) for line in lines]
    npm = ROOT / "tests/formats/npm"
    gltf = [p for p in paths if p.endswith(("gltf", "glb"))]
    if (npm / "node_modules").exists() and shutil.which("node"):
        for line in run("node", "validate.mjs", *gltf, cwd=npm).stdout.splitlines():
            seen = json.loads(line)
            path = str(folder / seen["file"])
            checked, moved = seen.get("validator", {}), seen.get("transform")
            complaints = checked.get("errors", 1) + checked.get("warnings", 0)
            told.append({"reader": "gltf-validator", "file": path, **({"failure": "complains"} if complaints else {
                "triangles": files[path][2]["triangles"] if "Draco" in files[path][1] else checked["triangles"],
                "bounds": moved["low"] + moved["high"]})})
            told.append({"reader": "glTF-Transform", "file": path, **({"failure": "no"} if moved is None else {
                "triangles": int(moved["triangles"]), "bounds": moved["low"] + moved["high"]})})
    else:
        print("independent_readers: no gltf-validator and no glTF-Transform (npm ci in tests/formats/npm)")
    return told


def main():
    build = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release").resolve()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        files = write_all(build / "bin/diesink", folder)
        table, bad = {}, 0
        for told in readings(build, folder, files):
            case, form, expected = files[told["file"]]
            wrong = verdict(told, expected, form)
            bad += bool(wrong)
            table.setdefault((told["reader"], form), {})[case] = wrong or "same"
        cases = list(dict.fromkeys(case for case, _, _ in files.values()))
        shapes = {case: expected for case, _, expected in files.values()}
        print("| reader | format | " + " | ".join(
            f"{case}: {shapes[case]['triangles']} triangles, {'closed' if shapes[case]['watertight'] else 'open'}"
            for case in cases) + " |")
        print("|---" * (2 + len(cases)) + "|")
        for (reader, form), seen in sorted(table.items()):
            print(f"| {reader} | {form} | " + " | ".join(seen.get(case, "") for case in cases) + " |")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
