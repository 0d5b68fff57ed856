#!/usr/bin/env python3
"""`diesink view`: the page as a browser shows it, in a headless Chromium that draws without a GPU."""
# SPDX-License-Identifier: Apache-2.0
import re
import time
import unittest

from browser import CHROMIUM, Browser
from program import BALL, FIG6, CommandLineTest, has_viewer

# A block of 10 x 10 x 4 to measure, on a plane of 20 x 20.
BLOCK = """SOLID-DEF
S1,4-PRIS,3
P1,5,5,-1
P2,15,15,4
BSURF-DEF
PLANE,0
BOOLE-DEF
B+S1
MACHI-DEF
X-RNG,0,20
Y-RNG,0,20
"""


def far_apart(a, b):
    return max(abs(p - q) for p, q in zip(a, b)) > 24


@unittest.skipIf(CHROMIUM is None, "no chromium")
@unittest.skipUnless(has_viewer(), "no viewer in this build")
class ViewInBrowser(CommandLineTest):
    """All tests share one browser; each opens a page of its own."""

    @classmethod
    def setUpClass(cls):
        cls.browser = Browser((760, 420))
        cls.addClassCleanup(cls.browser.__exit__)

    def open(self, *words):
        self.run_program("view", *words, "-o", "die.html")
        del self.browser.events[:]
        self.assertEqual(self.browser.open(self.folder / "die.html"), "open")

    def tearDown(self):
        self.assertEqual(self.browser.complaints(), [])
        self.assertEqual([url for url in self.browser.requests() if not url.endswith("/die.html")], [])

    def place(self, *point):
        """Where a point of the part is on the screen."""
        x, y, _ = self.browser.run(f"diesink.viewer.eye.project(diesink.viewer.scene.drawn({list(point)}))")
        return round(x), round(y)

    def color(self, x, y):
        return self.browser.screenshot(x, y, 1, 1)[0][0]

    def text(self, selector):
        return self.browser.run(f"document.querySelector('{selector}').innerText")

    def press(self, selector):
        self.browser.run(f"document.querySelector(`{selector}`).click()")

    def test_the_die_is_drawn_where_it_is(self):
        self.open(self.write("ball.part", BALL.format(extra="")))
        for view in ["iso", "plan", "front", "right"]:
            self.press(f"[data-view={view}]")
            x, y = self.place(5, 5, 3)
            background = self.color(4, 210)
            rows = self.browser.screenshot(x - 10, y, 21, 13)
            for i, j in [(10, 3), (2, 12), (18, 12)]:
                self.assertTrue(far_apart(rows[j][i], background), (view, i, j))
        # The ball has another colour than the plane.
        self.press("[data-view=plan]")
        self.assertTrue(far_apart(self.color(*self.place(5, 5, 3)), self.color(*self.place(1, 1, 0))))

    def test_a_click_picks_the_element_under_it(self):
        self.open(FIG6)
        self.press("[data-view=plan]")
        picked = set()
        for point in [(3, 3, 0), (20, 11, 0), (12, 20, 0)]:
            self.browser.click(*self.place(*point))
            name = self.text("#picked td")
            self.assertEqual(self.text("li.on span").split("\n")[0].split(" ")[0][:len(name)], name)
            picked.add(name)
        self.assertIn("B", picked)
        self.assertGreaterEqual(len(picked), 2)
        self.assertIn("mm²", self.text("#picked"))
        # What is switched off is neither drawn nor picked.
        x, y = self.place(3, 3, 0)
        before = self.color(x, y)
        for name in ["B", "floor"]:
            self.browser.run(f"[...document.querySelectorAll('li')].find(row => row.innerText.startsWith('{name}')).querySelector('input').click()")
        self.assertTrue(far_apart(self.color(x, y), before))
        self.browser.click(x, y)
        self.assertTrue(self.browser.run("document.querySelector('#picked').hidden"))

    def test_dragging_turns_and_the_wheel_zooms_about_the_pointer(self):
        self.open(FIG6)
        before = self.browser.run("diesink.viewer.eye.azimuth")
        self.browser.drag(200, 200, 300, 200)
        self.assertAlmostEqual(self.browser.run("diesink.viewer.eye.azimuth"), before - 0.8, delta=0.05)
        self.press("[data-view=plan]")
        x, y = self.place(10, 10, 0)
        scale = self.browser.run("diesink.viewer.eye.unitsPerPixel")
        self.browser.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=-100)
        self.browser.frame()
        self.assertLess(self.browser.run("diesink.viewer.eye.unitsPerPixel"), 0.9 * scale)
        self.assertLess(max(abs(a - b) for a, b in zip(self.place(10, 10, 0), (x, y))), 2)

    def test_measuring_snaps_to_vertices(self):
        self.open(self.write("block.part", BLOCK))
        self.press("#measure-on")
        for point in [(5, 5, 4), (15, 5, 4)]:
            x, y = self.place(*point)
            self.browser.click(x + 3, y - 2)
        told = self.text("#measure table")
        self.assertRegex(told, r"distance\s+10\.0000 mm")
        self.assertRegex(told, r"ΔZ\s+0\.0000 mm")
        x, y = self.place(15, 5, 0)
        self.browser.click(*self.place(15, 5, 4))
        self.browser.click(x, y)
        self.assertRegex(self.text("#measure table"), r"distance\s+4\.0000 mm")
        self.browser.frame()
        self.assertEqual(self.browser.run("document.querySelector('#marks text').textContent"), "4.0000 mm")

    def test_section(self):
        self.open(self.write("block.part", BLOCK))
        self.press("[data-view=front]")
        # A side lies in the plane z = 2 of the block, the cut at y = 10 shows the inside, hatched.
        x, y = self.place(10, 0, 2)
        self.press("[data-axis='1']")
        self.browser.run("(n => { n.value = 10; n.dispatchEvent(new Event('change')); })(document.querySelector('#cut-place input[type=number]'))")
        near = set(sum(self.browser.screenshot(x - 25, y - 8, 50, 16), []))
        self.assertGreater(max(map(sum, near)) - min(map(sum, near)), 60, "not hatched")
        outline = self.browser.run("diesink.viewer.section.parts.length")
        self.assertEqual(outline, 3)  # the stencil, the hatched sheet, the outline: the mesh is closed
        self.browser.click(x, y)
        picked = self.text("#picked") if not self.browser.run("document.querySelector('#picked').hidden") else ""
        self.assertNotRegex(picked, r"Y\s+0\.")  # the side that was cut away is not met

    def test_tool_path(self):
        self.write("one.csv", "x,y,z,motion\n0,0,20,rapid\n0,0,1,rapid\n10,0,1,feed\n10,10,1,feed\n")
        self.open(FIG6, "one.csv", "--cutter", "6,3")
        self.assertRegex(self.text("#path table"), r"point\s+4 of 4")
        self.browser.run("(s => { s.value = 24 / 39; s.dispatchEvent(new Event('input')); })(document.querySelector('#path-place'))")
        told = self.text("#path table")
        self.assertRegex(told, r"tip\s+5\.000\s+0\.000\s+1\.000")
        self.assertRegex(told, r"cutter\s+Ø 6, corner 3")
        self.assertEqual(self.browser.run("diesink.viewer.path.cutter.position.toArray().map((v, k) => Math.round(1e4 * (v + diesink.viewer.scene.own([0, 0, 0])[k])) / 1e4)"), [5, 0, 1])
        self.press("#path-on")
        self.assertRegex(self.text("#path table"), r"tip\s+10\.000\s+0\.000\s+1\.000")
        self.press("#path-back")
        self.assertRegex(self.text("#path table"), r"move\s+rapid")

    def test_colorings(self):
        self.write("one.csv", "x,y,z,motion\n1,20,22,rapid\n1,20,15,feed\n39,20,15,feed\n")
        self.open(FIG6, "one.csv", "--verify", "--cutter", "6,3")
        self.press("[data-view=plan]")
        x, y = self.place(20, 11, 0)
        seen = set()
        for name in ["element", "height", "slope", "deviation", "cut"]:
            self.browser.run(f"(s => {{ s.value = '{name}'; s.dispatchEvent(new Event('change')); }})(document.querySelector('#coloring'))")
            seen.add(str(self.browser.screenshot(x - 30, y - 30, 60, 60)))
        self.assertEqual(len(seen), 5)
        # The path would cover what it leaves; its box brings it back.
        shown = "diesink.viewer.path.done.visible"
        self.assertFalse(self.browser.run(shown))
        self.press("#path-shown input")
        self.assertTrue(self.browser.run(shown))

    def test_light_and_dark(self):
        self.open(FIG6)
        light = self.color(300, 415)
        self.press("#theme")
        dark = self.color(300, 415)
        self.assertGreater(sum(light), sum(dark) + 300)

    def test_a_million_triangles(self):
        self.run_program("view", FIG6, "--tolerance", "1.8e-5", "-o", "die.html")
        del self.browser.events[:]
        begin = time.monotonic()
        self.assertEqual(self.browser.open(self.folder / "die.html"), "open")
        seconds = time.monotonic() - begin
        triangles = int(re.sub(r"\D", "", re.search(r"([\d\s]+) triangles", self.text("#facts"))[1]))
        self.assertGreater(triangles, 1_000_000)
        print(f"a die of {triangles} triangles opens in {seconds:.2f} s, {(self.folder / 'die.html').stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    if CHROMIUM is None:
        print("chromium is not installed: the viewer's page is not looked at")
    unittest.main()
