#!/usr/bin/env python3
"""A die over a scanned mesh, as a user drives it: every command, and what it says where nothing can be proved."""
# SPDX-License-Identifier: Apache-2.0
import json
import math
import struct
import subprocess
import sys
import unittest

from program import SOURCE, CommandLineTest

NOT_KEPT = 5
PART = """SOLID-DEF
S1,R-CYLI,2
P1,20,42,-6
NOR,.1,.1,1
RAD,8
LEN,16
S2,SPHER
P1,66,14,4
RAD,9
BSURF-DEF
MESH,scan.stl
BOOLE-DEF
B+S1-S2
MACHI-DEF
TOLER,.05
X-INT,2
Y-INT,2
CUTTER,6,3
"""


class Scan(CommandLineTest):
    def scan(self, *words):
        subprocess.run([sys.executable, SOURCE / "scripts/make_scan.py", "--points", "49", *words,
                        self.folder / "scan.stl"], check=True)
        return self.write("die.part", PART)

    def test_report_tells_of_the_scan(self):
        part = self.scan()
        told = json.loads(self.run_program("info", part, "--json").stdout)["scan"]
        self.assertEqual(sorted(told), ["holes", "layered_area", "open_area"])
        said = json.loads(self.run_program("export", part, "-o", "die.stl", "--json", "--report",
                                           "die.json").stdout)
        told["crease_offset"] = 0
        self.assertEqual(said["scan"], told)
        self.assertEqual(json.loads((self.folder / "die.json").read_text())["scan"], told)

    def test_a_scan_beside_the_domain_is_a_hole(self):
        self.scan()
        away = PART.replace("P1,20,42", "P1,220,42").replace("P1,66,14", "P1,224,14").replace("B+S1-S2", "B+S1+S2")
        part = self.write("away.part", away + "X-RNG,200,240\nY-RNG,0,60\n")
        for options in ([], ["--tiles", "2x2"]):
            said = json.loads(self.run_program("export", part, "-o", "away.stl", "--solid", "--json", *options).stdout)
            self.assertTrue(said["watertight"])
            self.assertEqual((said["uncertified_area"], said["scan"]["open_area"]), (0, 2400))
            self.assertEqual({e["solid"] for e in said["elements"] if e["type"]}, {"S1", "S2"})
        self.run_program("cc", part, "-o", "away.csv")
        heights = [row.split(",")[2] for row in (self.folder / "away.csv").read_text().splitlines()[1:]]
        self.assertTrue(any(heights) and not all(heights))
        alone = "BSURF-DEF\n" + away.split("BSURF-DEF\n")[1].replace("B+S1+S2", "B")
        part = self.write("alone.part", alone + "X-RNG,200,240\nY-RNG,0,60\n")
        self.run_program("cc", part, "-o", "alone.csv")
        done = self.run_program("export", part, "-o", "alone.stl", status=2)
        self.assertIn(b"no triangle of the scan lies in the domain", done.stderr)

    def test_a_scan_that_cannot_be_read_is_told_where_the_program_names_it(self):
        part = self.write("die.part", PART)
        done = self.run_program("export", part, "-o", "die.stl", status=2)
        self.assertIn(b"die.part:11:6: error: ", done.stderr)
        self.assertIn(b"scan.stl: cannot read: No such file or directory", done.stderr)
        self.write("scan.stl", "solid\nfacet normal 0 0 1\nouter loup\n")
        done = self.run_program("export", part, "-o", "die.stl", status=2)
        self.assertIn(b"scan.stl:3:7: error: ", done.stderr)
        self.assertIn(b", as the base surface of ", done.stderr)
        self.assertFalse((self.folder / "die.stl").exists())

    def test_fill_closes_small_holes(self):
        part = self.scan()
        open_ = json.loads(self.run_program("info", part, "--json").stdout)["scan"]
        across = {}
        for size in ("3", "30"):
            filled = self.write("filled.part", PART.replace("MESH,scan.stl\n", "MESH,scan.stl\nFILL," + size + "\n"))
            across[size] = json.loads(self.run_program("info", filled, "--json").stdout)["scan"]
        self.assertEqual(across["3"], {**open_, "filled_holes": 0, "filled_area": 0})
        self.assertEqual((across["30"]["holes"], across["30"]["open_area"]), (0, 0))
        self.assertEqual(across["30"]["filled_holes"], 1)
        self.assertAlmostEqual(across["30"]["filled_area"], open_["open_area"], delta=1e-6)
        self.assertIn(b"1 hole filled", self.run_program("info", "filled.part").stdout)
        self.run_program("cc", "filled.part", "-o", "filled.csv")
        self.assertNotIn(",,", (self.folder / "filled.csv").read_text())
        done = self.run_program("export", "filled.part", "-o", "filled.stl", "--solid", "--json")
        self.assertEqual(json.loads(done.stdout)["scan"]["filled_holes"], 1)

    def test_export_is_closed_sharp_and_certified(self):
        part = self.scan("--plain")
        said = json.loads(self.run_program("export", part, "-o", "die.stl", "--solid", "--json").stdout)
        self.assertTrue(said["watertight"])
        self.assertEqual(said["uncertified_area"], 0)
        self.assertLessEqual(said["certified_deviation"], 0.05)
        self.assertLess(said["triangles"], 12000)
        between = {tuple(sorted(c["between"])) for c in said["curves"] if c["kind"] == "crease"}
        self.assertIn(("B", "S1.side"), between)
        self.assertIn(("B", "S2.surface"), between)
        mesh = json.loads(self.run_program("info", "die.stl", "--json").stdout)
        self.assertEqual(mesh["nonmanifold_edges"], 0)

    def test_overhang_is_certified(self):
        part = self.scan()
        said = json.loads(self.run_program("export", part, "-o", "die.glb", "--solid", "--json").stdout)
        self.assertTrue(said["watertight"])
        self.assertEqual(said["uncertified_area"], 0)
        self.assertLessEqual(said["certified_deviation"], 0.05)

    def test_scan_in_another_format(self):
        part = self.scan()
        of_stl = json.loads(self.run_program("info", part, "--json").stdout)["scan"]
        self.run_program("convert", "scan.stl", "scan.glb", "--units-in", "mm")
        self.write("glb.part", PART.replace("scan.stl", "scan.glb"))
        of_glb = json.loads(self.run_program("info", "glb.part", "--json").stdout)["scan"]
        self.assertEqual(of_glb["holes"], of_stl["holes"])
        for figure in ("open_area", "layered_area"):
            self.assertAlmostEqual(of_glb[figure], of_stl[figure], delta=1e-2)
        said = json.loads(self.run_program("export", "glb.part", "-o", "die.glb", "--solid", "--json").stdout)
        self.assertTrue(said["watertight"])
        self.assertEqual(said["uncertified_area"], 0)

    def test_feature_angle(self):
        part = self.scan("--plain")
        count = {}
        for angle in ("4", "80"):
            said = json.loads(self.run_program("export", part, "-o", "die.obj", "--feature-angle", angle, "--json").stdout)
            count[angle] = sum(c["between"] == ["B", "B"] for c in said["curves"])
        self.assertGreater(count["4"], count["80"])

    def test_grid_has_its_edge_points(self):
        done = self.run_program("export", self.scan(), "-o", "die.stl", "--mesh", "grid", "--solid", "--json",
                                status=NOT_KEPT)  # facets between the lines of the grid are passed over
        said = json.loads(done.stdout)
        self.assertTrue(said["watertight"])
        self.assertIn(["B", "S1.side"], [sorted(c["between"]) for c in said["curves"]])

    def test_cc_data_lies_on_the_facets(self):
        part = self.scan("--plain")
        self.run_program("cc", part, "-o", "die.csv")
        rows = (self.folder / "die.csv").read_text().splitlines()[1:]
        self.assertEqual(len(rows), 41 * 31)
        self.assertTrue(all(math.isfinite(float(row.split(",")[2])) for row in rows))

    def test_tool_path_and_its_check(self):
        part = self.scan("--plain")
        self.run_program("cl", part, "-o", "die.apt", "--interval", "4")
        self.run_program("verify", part, "die.apt", "--quiet")

    def test_info_and_preview(self):
        part = self.scan()
        said = json.loads(self.run_program("info", part, "--json").stdout)
        self.assertEqual([s["id"] for s in said["solids"]], ["S1", "S2"])
        self.assertEqual(said["scan"]["holes"], 1)
        self.assertGreater(said["scan"]["open_area"], 20)
        self.assertLess(said["scan"]["open_area"], 60)
        self.assertGreater(said["scan"]["layered_area"], 10)
        self.run_program("preview", part, "-o", "die.png")
        data = (self.folder / "die.png").read_bytes()
        self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
        self.assertGreater(struct.unpack_from(">I", data, 16)[0], 100)

    def test_a_town_of_walls_ends(self):
        """Thousands of upright walls in the cells of the plan: given out as the grid, told, and in seconds."""
        town = SOURCE / "../shared/corpus/good/glb-draco/cesium_tile.glb"
        if not town.exists():
            self.skipTest("there is no ../shared/corpus")
        part = self.write("die.part", f"""SOLID-DEF
S1,R-CYLI,2
P1,-76848.5,-70541,-233688
NOR,.1,.2,1
RAD,79769
LEN,545857
S2,SPHER
P1,82690,44341,214200
RAD,106359
BSURF-DEF
MESH,{town.resolve()}
BOOLE-DEF
B+S1-S2
MACHI-DEF
TOLER,1063.6
X-INT,10636
Y-INT,11488
""")
        told = json.loads(self.run_program("export", part, "-o", "die.ply", "--json", status=NOT_KEPT).stdout)
        self.assertGreater(told["triangles"], 1000)
        self.assertGreater(told["uncertified_area"], 0)

    def test_a_scan_that_is_not_there(self):
        part = self.write("die.part", PART)
        self.run_program("export", part, "-o", "die.stl", status=2)
        self.assertEqual(self.files(), ["die.part"])


if __name__ == "__main__":
    unittest.main()
