#!/usr/bin/env python3
"""`diesink preview` as a user drives it: pictures read by a decoder of the test's own."""
# SPDX-License-Identifier: Apache-2.0
import json
import struct
import unittest
import zlib

from program import BAD_INPUT, BALL, FIG6, NOT_WRITTEN, SOURCE, WRONG_USAGE, CommandLineTest, limited_file_size


def paeth(a, b, c):
    p = a + b - c
    return min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]


def decode(data):
    """Rows of (r, g, b) of an 8-bit RGB PNG; every checksum is checked."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + size]
        assert struct.unpack_from(">I", data, at + 8 + size)[0] == zlib.crc32(kind + body)
        if kind == b"IHDR":
            width, height, *how = struct.unpack(">IIBBBBB", body)
            assert how == [8, 2, 0, 0, 0]
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    raw, step, rows, above = zlib.decompress(packed), 3 * width, [], bytes(3 * width)
    for j in range(height):
        begin = j * (step + 1)
        kind, line = raw[begin], bytearray(raw[begin + 1:begin + 1 + step])
        for k in range(step):
            left, corner = (line[k - 3], above[k - 3]) if k >= 3 else (0, 0)
            line[k] = (line[k] + [0, left, above[k], (left + above[k]) // 2, paeth(left, above[k], corner)][kind]) & 255
        rows.append([tuple(line[k:k + 3]) for k in range(0, step, 3)])
        above = line
    return rows


class Preview(CommandLineTest):
    def picture(self, *words):
        self.run_program("preview", *words, "-o", "out.png")
        return decode((self.folder / "out.png").read_bytes())

    def test_every_view_and_coloring_of_a_part(self):
        seen = set()
        for view in ["plan", "iso", "front", "right"]:
            for color in ["element", "height", "slope", "deviation"]:
                rows = self.picture(FIG6, "--view", view, "--color", color, "--size", "160x120")
                self.assertEqual((len(rows[0]), len(rows)), (160, 120))
                drawn = sum(pixel != (255, 255, 255) for row in rows for pixel in row)
                self.assertGreater(drawn, 1500, (view, color))
                seen.add(repr(rows))
        self.assertEqual(len(seen), 16)

    def test_plan_shows_the_ball_where_it_is(self):
        part = self.write("ball.part", BALL.format(extra=""))
        rows = self.picture(part, "--view", "plan", "--size", "200x200", "--bare")
        # The margin is 3 % of the picture: 18.8 pixels a unit.
        self.assertEqual(rows[2][2], (255, 255, 255))

        def is_base(pixel):
            return max(pixel) - min(pixel) < 40

        self.assertTrue(is_base(rows[12][12]))
        for x, y in [(100, 100), (100, 60), (60, 100), (140, 100)]:
            self.assertFalse(is_base(rows[y][x]), (x, y))
        # Lit from the upper left.
        self.assertGreater(sum(rows[75][75]), sum(rows[125][125]))

    def test_a_mesh_looks_like_the_part_it_was_written_from(self):
        self.run_program("export", FIG6, "-o", "fig6.glb", "--solid=-2", "--lines", "--tolerance", "0.01")
        part = self.picture(FIG6, "--view", "plan", "--size", "160x120", "--bare", "--color", "slope")
        mesh = self.picture("fig6.glb", "--view", "plan", "--size", "160x120", "--bare", "--color", "slope")
        different = sum(max(abs(p - q) for p, q in zip(a, b)) > 40 for one, two in zip(part, mesh) for a, b in zip(one, two))
        self.assertLess(different, 160 * 120 * 0.02)

    def test_meshes_of_every_format(self):
        names = [f"fig6.{each}" for each in ["stl", "obj", "ply", "off", "glb"]]
        self.run_program("export", FIG6, "-o", *names)
        for name in names:
            with self.subTest(name):
                rows = self.picture(name, "--size", "120x90")
                self.assertGreater(len({pixel for row in rows for pixel in row}), 100)

    def test_part_on_a_scan(self):
        self.run_program("export", FIG6, "-o", "scan.stl")
        part = self.write("scan.part", "BSURF-DEF\nMESH,scan.stl\nBOOLE-DEF\nB\n")
        for view in ["plan", "iso"]:
            rows = self.picture(part, "--view", view, "--size", "120x90")
            self.assertGreater(len({pixel for row in rows for pixel in row}), 100, view)

    def test_figures(self):
        told = json.loads(self.run_program("preview", FIG6, "-o", "a.png", "--size", "64x48", "--json").stdout)
        self.assertEqual(list(told), ["width", "height", "seconds"])
        self.assertEqual((told["width"], told["height"]), (64, 48))

    def test_smallest_and_odd_sizes(self):
        for size in ["1x1", "3x700", "700x2"]:
            self.picture(FIG6, "--size", size)

    def test_what_is_wrong_leaves_nothing(self):
        for status, words in [(WRONG_USAGE, [FIG6, "-o", "a.jpg"]), (WRONG_USAGE, [FIG6, "-o", "a.png", "--size", "0x5"]),
                              (WRONG_USAGE, [FIG6, "-o", "a.png", "--view", "back"]),
                              (BAD_INPUT, [SOURCE / "fixtures/broken/empty.part", "-o", "a.png"]),
                              (BAD_INPUT, ["missing.part", "-o", "a.png"]),
                              (NOT_WRITTEN, [FIG6, "-o", "nowhere/a.png"])]:
            self.run_program("preview", *words, status=status)
            self.assertEqual(self.files(), [])
        self.run_program("preview", FIG6, "-o", "a.png", status=NOT_WRITTEN, preexec_fn=limited_file_size(1000))
        self.assertEqual(self.files(), [])
        self.run_program("export", FIG6, "-o", "a.stl")
        self.run_program("preview", "a.stl", "-o", "a.png", "--color", "deviation", status=WRONG_USAGE)
        self.assertEqual(self.files(), ["a.stl"])


if __name__ == "__main__":
    unittest.main()
