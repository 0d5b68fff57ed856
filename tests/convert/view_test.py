#!/usr/bin/env python3
"""`diesink view`: what stands in the page, read by a decoder of the test's own."""
# SPDX-License-Identifier: Apache-2.0
import base64
import json
import math
import re
import unittest
import zlib

from program import BAD_INPUT, BALL, FIG6, NOT_WRITTEN, SOURCE, WRONG_USAGE, CommandLineTest, has_viewer, limited_file_size


class Page:
    """The head and the arrays of a page."""

    def __init__(self, html):
        self.html = html
        self.head = json.loads(re.search(r'<script id="head"[^>]*>(.*?)</script>', html, re.S)[1])
        body = re.search(r'<script id="body"[^>]*>(.*?)</script>', html, re.S)[1]
        self.bytes = zlib.decompress(base64.b64decode(body, validate=True))

    def array(self, name):
        entry = self.head["arrays"][name]
        count, components, planes = entry["count"], entry["components"], entry["planes"]
        size = count * components
        codes = [0] * size
        for plane in range(planes):
            for c in range(components):
                begin = entry["at"] + plane * size + c * count
                for k, byte in enumerate(self.bytes[begin:begin + count]):
                    codes[k * components + c] |= byte << (8 * plane)
        if entry["code"] == "index":
            values, following = [], 0
            for code in codes:
                values.append(following - code)
                following += code == 0
            return values
        values = []
        for k, code in enumerate(codes):
            change = -(code + 1) // 2 if code & 1 else code // 2
            values.append(change + (values[k - components] if k >= components else 0))
        return values

    def points(self, name):
        steps, corner = self.array(name), self.head["corner"]
        return [tuple((steps[k + c] + corner[c]) / self.head["per_unit"] for c in range(3)) for k in range(0, len(steps), 3)]


def off_triangles(path):
    lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    count = int(lines[1].split()[0])
    points = [tuple(map(float, line.split()[:3])) for line in lines[2:2 + count]]
    return [[points[int(i)] for i in line.split()[1:4]] for line in lines[2 + count:]]


@unittest.skipUnless(has_viewer(), "no viewer in this build")
class View(CommandLineTest):
    def page(self, *words):
        self.run_program("view", *words, "-o", "die.html")
        return Page((self.folder / "die.html").read_text())

    def test_the_mesh_is_the_one_that_export_writes(self):
        self.run_program("export", FIG6, "-o", "fig6.off", "--solid", "--report", "report.json")
        report = json.loads((self.folder / "report.json").read_text())
        page = self.page(FIG6)
        head, positions, indices = page.head, page.points("position"), page.array("index")
        told = {each["solid"] + ("." + each["face"] if each["face"] != each["solid"] else ""): each for each in report["elements"]}
        shown = {each["name"]: each for each in head["elements"]}
        self.assertEqual(len(shown), len(told))
        # export keeps a hundredth of the tolerance for its floats, so its mesh is another one, of nearly the same areas.
        for name, each in shown.items():
            if not each["block"] and not name.endswith(".wall"):
                self.assertAlmostEqual(each["area"], told[name]["area"], delta=0.01 * told[name]["area"], msg=name)
        self.assertEqual(head["quantum"], 1e-4)
        self.assertEqual(sum(each["triangles"] for each in head["elements"]), len(indices) // 3)
        self.assertEqual(sum(each["vertices"] for each in head["elements"]), len(positions))
        # Each element has vertices of its own, in the order of the list.
        at_vertex = at_index = 0
        for each in head["elements"]:
            part = indices[at_index:at_index + 3 * each["triangles"]]
            self.assertEqual((min(part), max(part)), (at_vertex, at_vertex + each["vertices"] - 1), each["name"])
            at_vertex += each["vertices"]
            at_index += 3 * each["triangles"]
        # Closed: every side is met once each way.
        sides = set()
        for k in range(0, len(indices), 3):
            a, b, c = (positions[i] for i in indices[k:k + 3])
            for side in [(a, b), (b, c), (c, a)]:
                self.assertNotIn(side, sides)
                sides.add(side)
        self.assertTrue(all((b, a) in sides for a, b in sides))

    def test_coordinates_are_within_half_a_step(self):
        self.run_program("export", FIG6, "-o", "fig6.off")
        page = self.page("fig6.off")
        quantum = page.head["quantum"]
        self.assertEqual(quantum, 1e-5)  # a millionth of 38, rounded down to a power of ten
        positions, indices = page.points("position"), page.array("index")
        shown = {tuple(sorted(positions[i] for i in indices[k:k + 3])) for k in range(0, len(indices), 3)}
        given = {tuple(sorted(tuple(round(v / quantum) / round(1 / quantum) for v in p) for p in t)) for t in off_triangles(self.folder / "fig6.off")}
        self.assertEqual(shown, given)

    def test_normals_are_those_of_the_sphere(self):
        page = self.page(self.write("ball.part", BALL.format(extra="")))
        positions, octahedron = page.points("position"), page.array("normal")
        element = next(each for each in page.head["elements"] if each["name"] == "S1.surface")
        first = sum(each["vertices"] for each in page.head["elements"][:page.head["elements"].index(element)])
        worst = 0
        for v in range(first, first + element["vertices"]):
            u, w = octahedron[2 * v] / 2047, octahedron[2 * v + 1] / 2047
            z = 1 - abs(u) - abs(w)
            length = math.sqrt(u * u + w * w + z * z)
            away = [p - c for p, c in zip(positions[v], (5, 5, 0))]
            expected = [each / math.hypot(*away) for each in away]  # vertices stand off the sphere within the tolerance
            worst = max(worst, *(abs(a / length - b) for a, b in zip((u, w, z), expected)))
        self.assertLess(worst, 1.5e-3)

    def test_deviations(self):
        page = self.page(FIG6)
        step = page.head["deviation_step"]
        known = [each * step for each in page.array("deviation") if each != -32768]
        self.assertEqual(page.head["arrays"]["deviation"]["count"], page.head["arrays"]["index"]["count"] // 3)
        self.assertGreater(len(known), 1000)
        self.assertLessEqual(max(map(abs, known)), page.head["certified"])
        # The mesh of a ball lies inside it: half a degree of the tolerance at the least.
        self.assertLess(min(known), -0.25 * page.head["tolerance"])
        # Against the part, a mesh lifted by 0.5 stands 0.5 above every level place.
        self.write("plane.part", "BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB\nMACHI-DEF\nX-RNG,0,10\nY-RNG,0,10\n")
        self.write("high.off", "OFF\n4 2 0\n0 0 .5\n10 0 .5\n10 10 .5\n0 10 .5\n3 0 1 2\n3 0 2 3\n")
        page = self.page("plane.part", "high.off")
        self.assertEqual(page.head["coloring"], "deviation")
        for each in page.array("deviation"):
            self.assertAlmostEqual(each * page.head["deviation_step"], 0.5, places=4)

    def test_curves(self):
        page = self.page(self.write("ball.part", BALL.format(extra="")))
        curves, points, lengths = page.head["curves"], page.points("curve_point"), page.array("curve_length")
        self.assertEqual(sum(curves.values()), len(lengths))
        self.assertEqual(sum(lengths), len(points))
        self.assertGreaterEqual(curves["crease"] + curves["jump"], 1)
        # The ball's foot, and nothing else, lies between.
        foot = points[:lengths[0]]
        self.assertTrue(all(abs(math.hypot(x - 5, y - 5) - 3) < 1e-3 and abs(z) < 1e-3 for x, y, z in foot))

    def test_path(self):
        self.run_program("cl", FIG6, "--cutter", "6,3", "--interval", "4", "-o", "a.csv")
        page = self.page(FIG6, "a.csv", "--cutter", "4,1")
        rows = [line.split(",") for line in (self.folder / "a.csv").read_text().splitlines() if line[:1].isdigit() or line[:1] == "-"]
        points = page.points("path_point")
        self.assertEqual(len(points), len(rows))
        for shown, given in zip(points, rows):
            for a, b in zip(shown, given):
                self.assertLessEqual(abs(a - float(b)), 0.51 * page.head["quantum"])
        self.assertEqual(page.array("path_rapid"), [int(row[3] == "rapid") for row in rows])
        self.assertEqual(page.head["cutter"], {"diameter": 4, "corner_radius": 1})
        alone = self.page("a.csv")
        self.assertEqual((alone.head["elements"], len(alone.points("path_point"))), ([], len(rows)))

    def test_what_the_cutter_leaves(self):
        part = self.write("plane.part", "BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB\nMACHI-DEF\nX-RNG,0,10\nY-RNG,0,10\n")
        self.write("one.csv", "x,y,z,motion\n0,5,5,rapid\n0,5,.25,feed\n10,5,.25,feed\n")
        page = self.page(part, "one.csv", "--verify", "--cutter", "4,0")
        cut, heights = page.head["cut"], page.array("cut")
        self.assertEqual(len(heights), cut["columns"] * cut["rows"])
        row = [heights[j * cut["columns"] + cut["columns"] // 2] for j in range(cut["rows"])]
        at = lambda y: row[int((y - cut["corner"][1]) / cut["pixel"][1])]
        self.assertAlmostEqual(at(5) * cut["step"], 0.25, places=3)
        self.assertEqual((at(1), at(9)), (32767, 32767))

    def test_every_mesh_format(self):
        names = [f"fig6.{each}" for each in ["stl", "obj", "ply", "off", "glb", "gltf"]]
        self.run_program("export", FIG6, "-o", *names)
        counts = {name: sum(each["triangles"] for each in self.page(name).head["elements"]) for name in names}
        self.assertEqual(len(set(counts.values())), 1, counts)

    def test_names_cannot_end_the_script(self):
        self.write("odd.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\ng </script><script>alert(1)</script>\nf 1 2 3\n")
        page = self.page("odd.obj")
        self.assertIn("</script><script>", page.head["elements"][0]["name"])
        self.assertNotIn("alert(1)", re.sub(r'<script id="head".*?</script>', "", page.html, flags=re.S))

    def test_the_page_is_whole(self):
        html = self.page(FIG6).html
        self.assertIn("default-src 'none'", html)
        self.assertNotRegex(html, r"<(script|img|iframe)[^>]*\bsrc=|<link[^>]*href=\"(?!data:)|@import|\bimport\(")
        self.assertIn("three.js authors", html)

    def test_stdout_and_figures(self):
        html = self.run_program("view", FIG6, "-o", "-").stdout.decode()
        self.assertEqual(Page(html).head["title"], "fig6")
        told = json.loads(self.run_program("view", FIG6, "-o", "a.html", "--json").stdout)
        self.assertEqual(list(told), ["triangles", "elements", "points", "bytes", "seconds"])
        self.assertEqual(told["bytes"], (self.folder / "a.html").stat().st_size)

    def test_same_bytes_for_any_thread_count(self):
        self.assertEqual(self.page(FIG6, "--threads", "1").html, self.page(FIG6, "--threads", "5").html)

    def test_part_on_a_scan(self):
        self.run_program("export", FIG6, "-o", "scan.stl")
        self.write("scan.part", "BSURF-DEF\nMESH,scan.stl\nBOOLE-DEF\nB\n")
        self.assertGreater(self.page("scan.part").head["elements"][0]["triangles"], 1000)

    def test_what_is_wrong_leaves_nothing(self):
        self.write("a.csv", "x,y,z,motion\n0,0,5,rapid\n0,0,0,feed\n5,0,0,feed\n")
        self.write("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        self.write("empty.off", "OFF\n0 0 0\n")
        before = self.files()
        for status, words in [(WRONG_USAGE, [FIG6, "-o", "a.png"]), (WRONG_USAGE, [FIG6, FIG6, "-o", "a.html"]),
                              (WRONG_USAGE, ["a.csv", "a.csv", "-o", "a.html"]), (WRONG_USAGE, ["a.off", "a.off", "-o", "a.html"]),
                              (WRONG_USAGE, [FIG6, "--verify", "-o", "a.html"]), (WRONG_USAGE, [FIG6, "-o", "-", "--json"]),
                              (WRONG_USAGE, [FIG6, "-o", "a.html", "--tolerance", "0"]), (WRONG_USAGE, ["-o", "a.html"]),
                              (BAD_INPUT, ["empty.off", "-o", "a.html"]), (BAD_INPUT, ["missing.part", "-o", "a.html"]),
                              (BAD_INPUT, [SOURCE / "fixtures/broken/empty.part", "-o", "a.html"]),
                              (NOT_WRITTEN, [FIG6, "-o", "nowhere/a.html"])]:
            self.run_program("view", *words, status=status)
            self.assertEqual(self.files(), before)
        self.run_program("view", FIG6, "-o", "a.html", status=NOT_WRITTEN, preexec_fn=limited_file_size(1000))
        self.assertEqual(self.files(), before)


if __name__ == "__main__":
    unittest.main()
