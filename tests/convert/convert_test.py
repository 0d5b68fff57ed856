#!/usr/bin/env python3
"""`diesink convert` and meshes in `diesink info`, as a user drives them; the formats themselves have their own tests."""
# SPDX-License-Identifier: Apache-2.0
import base64
import json
import os
import re
import struct
import subprocess
import unittest

from program import BAD_INPUT, DONE, NOT_IN_BUILD, NOT_WRITTEN, PROGRAM, WRONG_USAGE, CommandLineTest, limited_file_size

# A tetrahedron: 4 vertices, 4 triangles, volume 1/6 of 2*3*4.
TETRA = """o tip
v 0 0 0
v 2 0 0
v 0 3 0
v 0 0 4
f 1 3 2
f 1 2 4
f 2 3 4
f 1 4 3
"""


def triangles_of_nodes(names):
    """A glTF scene of one triangle that every node shows under its own name."""
    corners = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(names)))}],
        "nodes": [{"name": name, "mesh": 0, "translation": [2 * i, 0, 0]} for i, name in enumerate(names)],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64," + base64.b64encode(corners).decode()}],
    }


class Convert(CommandLineTest):
    def vertices(self, name):
        found = re.findall(r"^v (\S+) (\S+) (\S+)$", (self.folder / name).read_text(), re.M)
        return sorted(tuple(float(number) for number in each) for each in found)

    def test_info_tells_triangles_that_cross(self):
        source = self.write("in.obj", TETRA)
        self.assertNotIn(b"crossing", self.run_program("info", source, "--json").stdout)
        self.assertIn("crossings   none", self.run_program("info", source, "--crossings").stdout.decode())
        # A triangle through the slanted face alone.
        through = self.write("through.obj", TETRA + "v 0.5 0.5 0.5\nv 2 2 2\nv 2 2.5 2\nf 5 6 7\n")
        text = self.run_program("info", through, "--crossings").stdout.decode()
        self.assertRegex(text, r"crossings   1 pair of triangles, the first 2 and 4 near 0\.\d+, ")
        told = json.loads(self.run_program("info", through, "--crossings", "--json").stdout)
        self.assertEqual((told["crossing_pairs"], told["crossing_triangles"]), (1, 2))
        self.assertEqual(told["first_crossing"]["triangles"], [2, 4])
        x, y, z = told["first_crossing"]["at"]
        self.assertAlmostEqual(x / 2 + y / 3 + z / 4, 1)

    def test_every_pair_of_formats_keeps_the_triangles(self):
        rows = json.loads(self.run_program("formats", "--json").stdout)["formats"]
        source = self.write("in.obj", TETRA)
        expected = self.vertices("in.obj")
        for first in (row for row in rows if row["writes"] and row["reads"]):
            a = "a" + first["endings"][0]
            self.run_program("convert", source, a, "--units-in", "mm", "--up-in", "z")
            for second in (row for row in rows if row["writes"]):
                with self.subTest(first=first["id"], second=second["id"]):
                    b = "b" + second["endings"][0]
                    told = json.loads(self.run_program("convert", a, b, "--json").stdout)
                    self.assertEqual((told["vertices"], told["triangles"]), (4, 4))
                    self.assertEqual((told["from"], told["to"]), (first["id"], second["id"]))
                    if second["reads"]:
                        self.run_program("convert", b, "c.obj", "--units-out", "mm", "--units-in", "mm")
                        self.assertEqual(self.vertices("c.obj"), expected)

    def test_units_and_up_axis(self):
        source = self.write("in.obj", TETRA)
        self.run_program("convert", source, "out.obj", "--units-in", "inch", "--units-out", "mm")
        self.assertEqual(self.vertices("out.obj"), [(0, 0, 0), (0, 0, 101.6), (0, 76.2, 0), (50.8, 0, 0)])
        self.run_program("convert", source, "out.obj", "--up-in", "y", "--up-out", "z")
        self.assertEqual(self.vertices("out.obj"), sorted([(0, 0, 0), (2, 0, 0), (0, 0, 3), (0, -4, 0)]))
        self.run_program("convert", "out.obj", "back.obj", "--up-in", "z", "--up-out", "y")
        self.assertEqual(self.vertices("back.obj"), self.vertices("in.obj"))

    def test_what_the_file_does_not_say_is_not_guessed(self):
        source = self.write("in.obj", TETRA)
        done = self.run_program("convert", source, "out.obj", "--units-out", "mm", status=WRONG_USAGE)
        self.assertIn(b"--units-in", done.stderr)
        done = self.run_program("convert", source, "out.obj", "--up-out", "z", status=WRONG_USAGE)
        self.assertIn(b"--up-in", done.stderr)
        self.assertEqual(self.files(), ["in.obj"])

    def test_doubtful_unit_is_told(self):
        source = self.write("in.obj", TETRA)
        done = self.run_program("convert", source, "out.off", "--units-in", "m", "--units-out", "mm")
        self.assertNotIn(b"m long", done.stderr)
        far = self.write("far.obj", TETRA.replace("v 2 0 0", "v 200000 0 0"))
        done = self.run_program("convert", far, "out.off")
        self.assertIn(b"far.obj: warning:", done.stderr)

    def test_what_is_lost_is_told(self):
        done = self.run_program("convert", self.write("in.obj", TETRA), "out.off")
        self.assertIn(b"out.off: warning:", done.stderr)
        self.assertIn(b"names", done.stderr)

    def test_what_each_kind_of_stl_loses_is_told(self):
        source = self.write("in.obj", TETRA)
        binary = self.run_program("convert", source, "out.stl", "--units-in", "mm").stderr
        self.assertIn(b"names", binary)
        self.assertNotIn(b"units", binary)
        text = self.run_program("convert", source, "out.stl", "--units-in", "mm", "--ascii").stderr
        self.assertIn(b"units", text)
        self.assertNotIn(b"names", text)
        # To stdout goes text, without being asked for.
        text = self.run_program("convert", source, "-", "--format", "stl", "--units-in", "mm").stderr
        self.assertIn(b"ASCII STL keeps no units", text)
        self.assertNotIn(b"names", text)

    def test_colours_and_vertices_that_stl_has_no_room_for_are_told(self):
        source = self.write("in.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 9 9 9 1 1 1\nf 1 2 3\n")
        for options, kind in (((), b"binary"), (("--ascii",), b"ASCII")):
            told = self.run_program("convert", source, "out.stl", *options).stderr
            self.assertIn(b"out.stl: warning: " + kind + b" STL keeps no colours of vertices: they are left out", told)
            self.assertIn(b"out.stl: warning: 1 vertex that belongs to no triangle is left out", told)
        self.assertEqual(self.run_program("convert", source, "out.ply").stderr, b"")
        text = self.run_program("info", "out.ply").stdout
        self.assertIn(b"unused      1 vertex of no triangle or line", text)
        self.assertIn(b'"unused_vertices":1', self.run_program("info", "--json", "out.ply").stdout)
        self.assertNotIn(b"unused", self.run_program("info", "out.stl").stdout)

    def test_names_that_text_cannot_hold_are_told(self):
        names = ["B", " S1.side", "S2\nside"]
        self.write("in.gltf", json.dumps(triangles_of_nodes(names)))
        for out, options in (("out.obj", ()), ("out.ply", ()), ("out.stl", ("--ascii",))):
            told = self.run_program("convert", "in.gltf", out, *options).stderr
            self.assertIn(b"2 names have blanks around or control characters", told, out)
            found = json.loads(self.run_program("info", "--json", out).stdout)["names"]
            self.assertEqual(found, ["B", "S1.side", "S2_side"], out)
        self.assertNotIn(b"control characters", self.run_program("convert", "in.gltf", "out.glb").stderr)
        self.assertEqual(json.loads(self.run_program("info", "--json", "out.glb").stdout)["names"], names)

    def test_more_bits_than_a_float_has_are_wrong_usage(self):
        source = self.write("in.obj", TETRA)
        done = self.run_program("convert", source, "out.glb", "--draco", "--quantize", "25", status=WRONG_USAGE)
        self.assertIn(b"from 1 to 24", done.stderr)

    def test_a_unit_or_axis_that_gltf_needs_and_nobody_told_is_told(self):
        source = self.write("in.obj", TETRA)
        for options, said in [([], b"unit and up axis are not told"), (["--units-in", "cm"], b"the up axis is not told"),
                              (["--up-in", "y"], b"the unit is not told"), (["--units-in", "mm", "--up-in", "z"], None)]:
            for name in ("out.glb", "out.gltf"):
                done = self.run_program("convert", source, name, *options)
                if said is None:
                    self.assertNotIn(b"not told", done.stderr)
                else:
                    self.assertIn(b"in.obj: warning: " + said, done.stderr)
        self.assertNotIn(b"not told", self.run_program("convert", source, "out.ply").stderr)

    def test_stdin_and_stdout(self):
        source = TETRA.encode()
        done = self.run_program("convert", "-", "-", "--format", "off", stdin=source)
        self.assertTrue(done.stdout.startswith(b"OFF"))
        self.assertEqual(self.files(), [])

    def test_outputs_that_cannot_be_written(self):
        source = self.write("in.obj", TETRA)
        self.run_program("convert", source, "out.xyz", status=WRONG_USAGE)
        self.run_program("convert", source, "none/out.stl", status=NOT_WRITTEN)
        self.run_program("convert", source, "out.stl", status=NOT_WRITTEN, preexec_fn=limited_file_size(100))
        self.assertEqual(self.files(), ["in.obj"])

    def test_broken_meshes(self):
        for name, text in [("a.stl", "solid x\nfacet normal 0 0 1\n"), ("b.obj", "v 1 2\n"), ("c.ply", "ply\n"),
                           ("d.off", "OFF\n3 1 0\n0 0 0\n"), ("e.glb", b"glTF\2\0\0\0\x0c\0\0\0"), ("f.stl", "")]:
            with self.subTest(name):
                done = self.run_program("convert", self.write(name, text), "out.obj", status=BAD_INPUT)
                self.assertIn(name.encode(), done.stderr)
                self.assertIn(b"error:", done.stderr)
                self.assertFalse((self.folder / "out.obj").exists())

    def test_weld_and_repair_only_when_asked(self):
        # The tip's third triangle turned over, its fourth missing, and one corner 0.01 off.
        source = self.write("in.obj", TETRA.replace("v 0 0 4", "v 0 0 4\nv 0 0 4.01")
                            .replace("f 2 3 4", "f 4 3 2").replace("f 1 4 3", "f 1 5 3"))
        broken = json.loads(self.run_program("info", source, "--json").stdout)
        self.assertFalse(broken["watertight"])
        self.run_program("convert", source, "plain.ply")
        plain = json.loads(self.run_program("info", "plain.ply", "--json").stdout)
        self.assertEqual((plain["vertices"], plain["misoriented_edges"]),
                         (broken["vertices"], broken["misoriented_edges"]))
        welded = json.loads(self.run_program("convert", source, "w.ply", "--weld", "0.1", "--json").stdout)
        self.assertEqual(welded["weld"], {"merged_vertices": 1, "collapsed_triangles": 0})
        table = self.run_program("convert", source, "r.ply", "--weld", "0.1", "--repair").stdout.decode()
        self.assertIn("before", table)
        mended = json.loads(self.run_program("info", "r.ply", "--json").stdout)
        self.assertEqual((mended["watertight"], mended["vertices"], mended["triangles"]), (True, 4, 4))
        self.assertAlmostEqual(mended["volume"], 4, places=12)

    def test_what_this_build_cannot_do(self):
        done = self.run_program("convert", self.write("a.off", b"OFF BINARY\n" + bytes(40)), "out.obj",
                                status=NOT_IN_BUILD)
        self.assertIn(b"binary OFF is not read", done.stderr)
        self.assertEqual(self.files(), ["a.off"])

    def test_limits(self):
        source = self.write("in.obj", TETRA * 20000)
        self.run_program("convert", source, "out.obj", "--max-memory", "1", status=BAD_INPUT)

    def peak(self, *words):
        """Exit status and largest memory in MiB of a run."""
        process = subprocess.Popen([PROGRAM, *map(str, words)], cwd=self.folder, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE)
        with process.stderr:
            told = process.stderr.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, used.ru_maxrss / 1024, told

    def test_memory_of_reading_is_bounded(self):
        # A grid of 40,000 vertices, the 80,000 triangles of which take megabytes in every format.
        side = 200
        lines = [f"v {x} {y} {x * y % 7}" for y in range(side) for x in range(side)]
        for y in range(side - 1):
            for x in range(side - 1):
                a = y * side + x + 1
                lines += [f"f {a} {a + 1} {a + side}", f"f {a + 1} {a + side + 1} {a + side}"]
        source = self.write("in.obj", "\n".join(lines) + "\n")
        small = self.write("small.obj", TETRA)
        rows = json.loads(self.run_program("formats", "--json").stdout)["formats"]
        for row in rows:
            for more in [[], ["--draco"]] if row["id"] in ("gltf", "glb") else [[]]:
                name = "m" + row["endings"][0]
                self.run_program("convert", source, name, "--units-in", "mm", *more)
                _, idle, _ = self.peak("info", small)
                kept, _, _ = self.peak("info", name, "--max-memory", 256)
                self.assertEqual(kept, DONE)
                refused = 0
                for most in (1, 2, 4, 8, 12):
                    with self.subTest(name, more=more, most=most):
                        status, used, told = self.peak("info", name, "--max-memory", most)
                        self.assertIn(status, (DONE, BAD_INPUT))
                        if status == BAD_INPUT:
                            refused += 1
                            self.assertRegex(told, rb"memory|larger than the limit")
                            # Stacks of threads and what the heap keeps back come on top.
                            self.assertLess(used, idle + most + 8)
                self.assertGreater(refused, 0)


class MeshInfo(CommandLineTest):
    KEYS = ["format", "vertices", "triangles", "lines", "shells", "boundary_loops", "nonmanifold_edges", "watertight",
            "area", "volume", "bounds", "units", "up", "names"]

    def test_json(self):
        told = json.loads(self.run_program("info", self.write("in.obj", TETRA), "--json").stdout)
        self.assertEqual(list(told)[:len(self.KEYS)], self.KEYS)
        self.assertEqual([told[key] for key in self.KEYS[:8]], ["obj", 4, 4, 0, 1, 0, 0, True])
        self.assertAlmostEqual(told["volume"], 4, places=12)
        self.assertAlmostEqual(told["area"], 3 + 4 + 6 + 61 ** 0.5, places=12)
        self.assertEqual(told["bounds"], [[0, 0, 0], [2, 3, 4]])
        self.assertEqual((told["units"], told["up"], told["names"]), ("unknown", "unknown", ["tip"]))

    def test_open_mesh_tells_why(self):
        open_tetra = self.write("in.obj", TETRA.rsplit("f", 1)[0])
        text = self.run_program("info", open_tetra).stdout.decode()
        self.assertIn("watertight  no: 3 boundary edges", text)
        self.assertEqual(json.loads(self.run_program("info", open_tetra, "--json").stdout)["boundary_loops"], 1)

    def test_content_comes_before_the_ending(self):
        told = self.run_program("info", self.write("mesh.part", TETRA), "--json", status=BAD_INPUT)
        self.assertIn(b"mesh.part", told.stderr)  # OBJ has no magic word: the ending decides
        self.write("off.stl", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        self.assertEqual(json.loads(self.run_program("info", "off.stl", "--json").stdout)["format"], "off")
        self.write("part.stl", "$$ a plane\nbsurf-def\nPLANE,1\nBOOLE-DEF\nB\nMACHI-DEF\nX-RNG,0,1\nY-RNG,0,1\n")
        self.assertIn("boole", json.loads(self.run_program("info", "part.stl", "--json").stdout))

    def test_mesh_from_stdin(self):
        told = json.loads(self.run_program("info", "-", "--json", stdin=TETRA.encode()).stdout)
        self.assertEqual(told["triangles"], 4)


if __name__ == "__main__":
    unittest.main()
