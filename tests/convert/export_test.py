#!/usr/bin/env python3
"""`diesink export` as a user drives it: files, options, figures, status."""
# SPDX-License-Identifier: Apache-2.0
import hashlib
import json
import signal
import struct
import unittest

from program import (ALLPRIMS, BAD_INPUT, BALL, DONE, FIG6, NOT_KEPT, NOT_WRITTEN, SOURCE, WRONG_USAGE, CommandLineTest,
                     limited_file_size)

FORMATS = ["stl", "obj", "ply", "off", "gltf", "glb"]
REPORT = ["triangles", "vertices", "crease_vertices", "jump_vertices", "corner_vertices", "tolerance",
          "certified_deviation", "uncertified_area", "area", "volume", "watertight", "domain", "bounds", "elements",
          "curves", "seconds", "threads", "version"]

# A cone whose apex stands out over its rim by a hair.
OVERHANGING = """SOLID-DEF
K,R-CONE,1
P1,15,20,-5
P2,25.0000001,20,5
RAD,14.142135623730951
BSURF-DEF
PLANE,0
BOOLE-DEF
B+K
MACHI-DEF
X-RNG,0,40
Y-RNG,0,40
TOLER,.05
"""


class Export(CommandLineTest):
    def digest(self, name):
        return hashlib.sha256((self.folder / name).read_bytes()).hexdigest()

    def test_every_format_holds_the_same_mesh(self):
        told = json.loads(self.run_program("export", FIG6, "-o", *[f"fig6.{each}" for each in FORMATS], "--json").stdout)
        self.assertEqual(self.files(), sorted([f"fig6.{each}" for each in FORMATS] + ["fig6.mtl", "fig6.bin"]))
        for each in FORMATS:
            with self.subTest(each):
                read = json.loads(self.run_program("info", f"fig6.{each}", "--json").stdout)
                self.assertEqual(read["format"], each)
                self.assertEqual(read["triangles"], told["triangles"])
                self.assertEqual(read["vertices"], told["vertices"])
                self.assertEqual(read["degenerate"] + read["flat"] + read["duplicates"], 0)

    def test_report_has_the_keys_in_their_order(self):
        done = self.run_program("export", FIG6, "-o", "fig6.stl", "--json", "--report", "report.json", "--threads", 2)
        told = json.loads(done.stdout)
        filed = json.loads((self.folder / "report.json").read_text())
        self.assertEqual(list(told), REPORT)
        self.assertEqual(list(filed), REPORT)
        self.assertEqual(list(told["elements"][0]),
                         ["solid", "type", "face", "sign", "triangles", "area", "max_deviation"])
        self.assertEqual(list(told["curves"][0]), ["kind", "between", "length", "closed"])
        self.assertEqual(list(told["seconds"]), ["parse", "evaluate", "tessellate", "write", "total"])
        self.assertEqual(told["threads"], 2)
        self.assertEqual(told["tolerance"], 0.02)
        self.assertLessEqual(told["certified_deviation"], 0.02)
        self.assertEqual(told["uncertified_area"], 0)
        self.assertEqual(told["domain"], [1, 39, 1, 39])
        self.assertEqual(sum(each["triangles"] for each in told["elements"]), told["triangles"])
        for key in REPORT[:15]:
            self.assertEqual(told[key], filed[key], key)

    def test_doubts_are_told_by_place(self):
        # A cone's apex stands out over its rim by less than a millionth of the size: not told from one that does not.
        self.write("overhanging.part", OVERHANGING)
        done = self.run_program("export", "overhanging.part", "-o", "overhanging.stl", "--json", status=NOT_KEPT)
        told = json.loads(done.stdout)
        self.assertGreater(told["uncertified_area"], 0)
        self.assertGreater(told["doubt_count"], 0)
        self.assertEqual(list(told["doubts"][0]), ["place", "element", "what", "area"])
        self.assertLessEqual(sum(each["area"] for each in told["doubts"]), told["uncertified_area"])

    def test_extras_of_gltf_are_the_figures_that_do_not_change(self):
        told = json.loads(self.run_program("export", FIG6, "-o", "fig6.glb", "--json").stdout)
        data = (self.folder / "fig6.glb").read_bytes()
        length, = struct.unpack_from("<I", data, 12)
        extras = json.loads(data[20:20 + length])["asset"]["extras"]
        self.assertEqual(extras["triangles"], told["triangles"])
        self.assertNotIn("seconds", extras)
        self.assertNotIn("threads", extras)

    def test_same_bytes_for_any_thread_count_locale_and_line_ending(self):
        crlf = self.folder / "fig6.part"
        crlf.write_bytes(FIG6.read_bytes().replace(b"\n", b"\r\n"))
        outputs = [f"x.{each}" for each in FORMATS]
        digests = set()
        for part, threads in [(FIG6, 1), (FIG6, 2), (FIG6, 7), (crlf, 2)]:
            self.run_program("export", part, "-o", *outputs, "--lines", "--threads", threads)
            digests.add(tuple(self.digest(name) for name in [*outputs, "x.mtl", "x.bin"]))
        self.assertEqual(len(digests), 1)
        for threads in [1, 2, 7]:
            self.run_program("export", ALLPRIMS, "-o", "a.ply", "--solid", "--threads", threads, status=(DONE, NOT_KEPT))
            digests.add(self.digest("a.ply"))
        self.assertEqual(len(digests), 2)

    def test_solid(self):
        told = json.loads(self.run_program("export", FIG6, "-o", "s.ply", "--solid=-5", "--json").stdout)
        self.assertTrue(told["watertight"])
        self.assertEqual(told["bounds"][0][2], -5)
        read = json.loads(self.run_program("info", "s.ply", "--json").stdout)
        self.assertTrue(read["watertight"], read["why_not_watertight"])
        self.assertEqual(read["shells"], 1)
        self.assertAlmostEqual(read["volume"] / told["volume"], 1, places=9)
        self.assertIn("floor", read["names"])
        self.assertIn("skirt", read["names"])
        self.run_program("export", "--solid", FIG6, "-o", "d.ply")  # the word after --solid is the part program

    def test_tolerance(self):
        coarse, fine = [json.loads(self.run_program("export", FIG6, "-o", "x.stl", "--json", "--tolerance", t).stdout)
                        for t in ["0.1", "0.01"]]
        self.assertGreater(fine["triangles"], coarse["triangles"])
        self.assertLessEqual(fine["certified_deviation"], 0.01)

    def test_not_kept_is_status_5_and_written(self):
        # Far from the origin a 32-bit float cannot hold the tolerance; 64 bits can.
        far = BALL.format(extra="TOLER,.001\n").replace("P1,5,5,0", "P1,5000005,5,0").replace("X-RNG,0,10",
                                                                                               "X-RNG,5000000,5000010")
        part = self.write("far.part", far)
        done = self.run_program("export", part, "-o", "far.stl", status=NOT_KEPT)
        self.assertIn(b"far.part: warning: the tolerance 0.001 is not certified", done.stderr)
        self.assertIn("far.stl", self.files())
        self.run_program("export", part, "-o", "far.ply")

    def test_grid(self):
        # The spacing decides, not the tolerance, so the tolerance is not kept.
        words = ["export", FIG6, "-o", "grid.ply", "--mesh", "grid", "--json"]
        creased = json.loads(self.run_program(*words, status=NOT_KEPT).stdout)
        self.assertGreater(creased["crease_vertices"], 0)
        plain = json.loads(self.run_program(*words, "--no-creases", status=NOT_KEPT).stdout)
        self.assertEqual((plain["crease_vertices"], plain["triangles"]), (0, 2 * 48 * 48))
        self.assertAlmostEqual(plain["uncertified_area"], 38 * 38, places=9)
        self.assertAlmostEqual(plain["volume"] / creased["volume"], 1, delta=0.05)
        told = json.loads(self.run_program(*words, "--no-creases", "--tiles", "2x3", status=NOT_KEPT).stdout)
        self.assertAlmostEqual(told["uncertified_area"], 38 * 38, places=9)
        self.run_program("export", FIG6, "-o", "x.ply", "--no-creases", status=WRONG_USAGE)

    def test_lines(self):
        for each, word in [("ply", b"element edge "), ("obj", b"\nl ")]:
            self.run_program("export", FIG6, "-o", f"a.{each}", "--lines")
            self.run_program("export", FIG6, "-o", f"b.{each}")
            self.assertIn(word, (self.folder / f"a.{each}").read_bytes())
            self.assertNotIn(word, (self.folder / f"b.{each}").read_bytes())
        self.assertIn(b"lines", self.run_program("export", FIG6, "-o", "a.stl", "--lines").stderr)

    def test_split(self):
        names = {}
        for split in ["element", "solid", "none"]:
            self.run_program("export", FIG6, "-o", "x.obj", "--split", split)
            names[split] = json.loads(self.run_program("info", "x.obj", "--json").stdout)["names"]
        self.assertIn("S2.top", names["element"])
        self.assertIn("S2.wall", names["element"])
        self.assertLessEqual(set(names["solid"]), {"B", "S2", "S3", "S5", "S7", "S8", "S9"})
        self.assertIn("S2", names["solid"])
        self.assertEqual(names["none"], ["fig6"])

    def test_tiles(self):
        whole = json.loads(self.run_program("export", FIG6, "-o", "whole.ply", "--json").stdout)
        told = json.loads(self.run_program("export", FIG6, "-o", "t.ply", "--tiles", "2x1", "--json").stdout)
        self.assertEqual(self.files(), ["t_0_0.ply", "t_1_0.ply", "whole.ply"])
        self.assertAlmostEqual(told["area"] / whole["area"], 1, places=2)
        tiles = [json.loads(self.run_program("info", f"t_{i}_0.ply", "--json").stdout) for i in range(2)]
        self.assertEqual(sum(each["triangles"] for each in tiles), told["triangles"])
        # The middle is the axis of three solids: the cut keeps off their ends, by an eighth of a tile at most.
        cut = tiles[0]["bounds"][1][0]
        self.assertEqual(tiles[1]["bounds"][0][0], cut)
        self.assertLessEqual(abs(cut - 20), 19 / 8)

    def test_ascii_and_draco(self):
        self.run_program("export", FIG6, "-o", "a.stl", "--ascii")
        self.assertTrue((self.folder / "a.stl").read_bytes().startswith(b"solid "))
        told = json.loads(self.run_program("export", FIG6, "-o", "d.glb", "--draco", "--json").stdout)
        self.assertLessEqual(told["certified_deviation"], 0.02)
        self.run_program("export", FIG6, "-o", "p.glb")
        self.assertLess((self.folder / "d.glb").stat().st_size, (self.folder / "p.glb").stat().st_size / 2)
        read = json.loads(self.run_program("info", "d.glb", "--json").stdout)
        self.assertEqual(read["triangles"], told["triangles"])
        # 8 bits over 38 mm are 0.15 mm: not within 0.02.
        self.run_program("export", FIG6, "-o", "d.glb", "--draco", "--quantize", "8", status=NOT_KEPT)

    def test_options_that_do_not_fit(self):
        for words in [["-o", "x.stl", "--draco"], ["-o", "x.glb", "--ascii"], ["-o", "x.glb", "--draco-speed", "3"],
                      ["-o", "x.glb", "--draco", "--draco-speed", "11"], ["-o", "x.xyz"], ["-o", "x.stl", "x.stl"],
                      ["-o", "-", "--json"], ["-o", "-", "--tiles", "2x2"], ["-o", "x.stl", "--tiles", "2"],
                      ["-o", "x.stl", "--tiles", "0x1"], ["-o", "x.stl", "--tolerance", "0"],
                      ["-o", "x.stl", "--tolerance", "nan"], ["-o", "x.stl", "--solid=x"],
                      ["-o", "x.stl", "--mesh", "gird"], []]:
            with self.subTest(words):
                self.run_program("export", FIG6, *words, status=WRONG_USAGE)
        self.assertEqual(self.files(), [])
        self.assertIn(b"did you mean 'grid'", self.run_program("export", FIG6, "-o", "x.stl", "--mesh", "gird",
                                                               status=WRONG_USAGE).stderr)

    def test_stdout(self):
        self.run_program("export", FIG6, "-o", "x.obj")
        plain = self.run_program("export", FIG6, "-o", "-").stdout
        self.assertEqual(plain.count(b"\nv "), (self.folder / "x.obj").read_bytes().count(b"\nv "))
        self.assertTrue(self.run_program("export", FIG6, "-o", "-", "--format", "stl").stdout.startswith(b"solid "))

    def test_bad_input_writes_nothing(self):
        for part in sorted((SOURCE / "fixtures/broken").glob("*.part"))[::7]:
            self.run_program("export", part, "-o", "x.stl", "x.obj", "--report", "r.json", status=BAD_INPUT)
        # No surface anywhere in the domain.
        empty = BALL.format(extra="").replace("PLANE,0", "NONE").replace("B+S1", "S1").replace("P1,5,5,0", "P1,50,50,0")
        self.run_program("export", self.write("e.part", empty), "-o", "x.stl", status=BAD_INPUT)
        self.assertEqual(self.files(), ["e.part"])

    def test_missing_folder_and_full_disk(self):
        self.run_program("export", FIG6, "-o", "x.stl", "none/x.obj", status=NOT_WRITTEN)
        for each in FORMATS:
            self.run_program("export", FIG6, "-o", f"x.{each}", status=NOT_WRITTEN, preexec_fn=limited_file_size(5000))
        self.run_program("export", FIG6, "-o", "x.stl", "--report", "none/r.json", status=NOT_WRITTEN)
        self.assertEqual(self.files(), [])

    def test_interrupted_write_leaves_nothing(self):
        part = self.write("p.part", BALL.format(extra=""))
        ended = self.interrupt_while_writing("export", part, "-o", "x.obj", "x.ply", "--mesh", "adaptive",
                                             "--tolerance", "1e-5")
        self.assertEqual(ended, -signal.SIGINT)
        self.assertEqual(self.files(), ["p.part"])


if __name__ == "__main__":
    unittest.main()
