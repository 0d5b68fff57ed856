"""cl and verify from end to end; G-code through LinuxCNC's own interpreter."""
# SPDX-License-Identifier: Apache-2.0
import itertools
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import unittest

from program import BAD_INPUT, BALL, DONE, FIG6, NOT_KEPT, SOURCE, WRONG_USAGE, CommandLineTest

MACHINED = BALL.format(extra="CUTTER,4,2\nCUSP,0.05\nTOLER,0.02\nFEDRAT,700\nSPINDL,9000\n")


def interpreter():
    """rs274 and its environment: installed, or unpacked from Debian's package; None with a printed reason."""
    found = shutil.which("rs274")
    if found:
        return found, dict(os.environ)
    place = pathlib.Path(os.environ["DIESINK_PROGRAM"]).resolve().parent / "linuxcnc"
    program = place / "usr/bin/rs274"
    if not program.exists():
        place.mkdir(exist_ok=True)
        try:
            subprocess.run(["apt-get", "download", "-q", "linuxcnc-uspace", "libboost-python1.74.0"], cwd=place, check=True,
                           capture_output=True, timeout=240)
            for package in place.glob("*.deb"):
                subprocess.run(["dpkg-deb", "-x", package, place], check=True, capture_output=True, timeout=120)
                package.unlink()
        except (OSError, subprocess.SubprocessError) as problem:
            print(f"skipped: rs274 of linuxcnc-uspace is not installed and could not be unpacked ({problem})")
            return None
    libraries = f"{place}/usr/lib:{place}/usr/lib/x86_64-linux-gnu"
    environment = {**os.environ, "LD_LIBRARY_PATH": libraries}
    check = subprocess.run(["ldd", program], env=environment, capture_output=True, text=True)
    if "not found" in check.stdout or check.returncode != 0:
        print("skipped: rs274 lacks libraries here: " + " ".join(re.findall(r"\S+ => not found", check.stdout)))
        return None
    return str(program), environment


class Cl(CommandLineTest):
    def test_a_path_passes_its_own_verification_in_every_format(self):
        part = self.write("ball.part", MACHINED)
        self.run_program("cl", part, "-o", "a.apt", "-o", "a.ngc", "-o", "a.csv", "-o", "a.cls")
        for name in ("a.apt", "a.ngc", "a.csv", "a.cls"):
            found = json.loads(self.run_program("verify", part, name, "--json").stdout)
            self.assertLessEqual(found["max_gouge"] - found["bound"], 0.02)
            self.assertGreater(found["cusp_p50"], -1e-9)
            self.assertLess(found["cusp_p99"], 0.07)
            self.assertEqual(found["rapid_plunges"], 0)
            self.assertEqual(list(found)[:11],
                             ["max_gouge", "max_gouge_at", "max_excess", "max_excess_at", "cusp_p50", "cusp_p99", "cusp_max",
                              "uncut_area", "bound", "points", "length"])

    def test_options_reach_the_path(self):
        part = self.write("ball.part", MACHINED)
        text = self.run_program("cl", part, "-o", "-", "--feed", "333", "--cutter", "3,0.5", "--flavour", "nx").stdout.decode()
        self.assertIn("\nFEDRAT/MMPM,333.\n", text)
        self.assertIn("\nCUTTER/3.,0.5,1.,0.5,0.,0.,12.\n", text)
        one = json.loads(self.run_program("cl", part, "-o", "a.csv", "--interval", "1", "--json").stdout)
        self.assertEqual(one["passes"], 11)
        for along in ("y", "30"):
            self.run_program("cl", part, "-o", "b.csv", "--along", along, "--pattern", "oneway")
            self.run_program("verify", part, "b.csv", "--quiet")
        cc = json.loads(self.run_program("cl", part, "-o", "c.csv", "--method", "cc", "--cc", "cc.csv", "--json").stdout)
        self.assertGreater(cc["loops_removed"], 5)
        self.assertTrue((self.folder / "cc.csv").read_text().startswith("pass,x,y,z,nx,ny,nz\n"))

    def test_seeded_errors_are_found(self):
        part = self.write("ball.part", MACHINED)
        self.run_program("cl", part, "-o", "a.csv")
        lines = (self.folder / "a.csv").read_text().splitlines()
        feeds = [k for k, line in enumerate(lines) if line.endswith(",feed")]
        low = lines[feeds[len(feeds) // 3]].split(",")
        low[2] = repr(float(low[2]) - 0.06)
        lines[feeds[len(feeds) // 3]] = ",".join(low)
        self.write("low.csv", "\n".join(lines) + "\n")
        done = self.run_program("verify", part, "low.csv", "--json", status=NOT_KEPT)
        self.assertGreater(json.loads(done.stdout)["max_gouge"], 0.03)
        self.run_program("verify", part, "a.csv", "--cutter", "6,3", "--quiet", status=NOT_KEPT)

    def test_paths_in_the_words_of_other_systems(self):
        # Down, to the boss, round it, back: all of them the same (fixtures/paths/README.md).
        length = 12 + 12 + 2 * math.pi * 13 + 12
        paths = SOURCE / "fixtures/paths"
        files = [path for path in sorted(paths.iterdir()) if path.suffix not in (".part", ".md")]
        self.assertGreaterEqual(len(files), 6)
        for path in files:
            found = json.loads(self.run_program("verify", paths / "boss.part", path, "--cutter", "6,0", "--json").stdout)
            self.assertAlmostEqual(found["length"], length, delta=1e-3, msg=path.name)
            # The chords may cut in by their height, 0.0001.
            self.assertLess(found["max_gouge"], 2e-4, path.name)
            self.assertGreater(found["bound"], 1e-4, path.name)
            # Clean is a ring of the cutter's width at the foot of the boss, and the way to it.
            ring = math.pi * (16 ** 2 - 10 ** 2) + 6 * 10 + math.pi * 9 / 2
            self.assertAlmostEqual(found["uncut_area"], 60 * 40 - ring, delta=25, msg=path.name)

    def test_a_map_is_a_picture(self):
        part = self.write("ball.part", MACHINED)
        self.run_program("cl", part, "-o", "a.apt")
        self.run_program("verify", part, "a.apt", "--map", "a.png")
        self.assertEqual((self.folder / "a.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")

    def test_what_cannot_be_is_told_and_nothing_written(self):
        part = self.write("ball.part", MACHINED)
        bare = self.write("bare.part", BALL.format(extra=""))
        for words, status in ((("cl", bare, "-o", "x.apt"), BAD_INPUT),
                              (("cl", part, "-o", "x.txt"), WRONG_USAGE),
                              (("cl", part, "-o", "x.apt", "--clear", "1"), BAD_INPUT),
                              (("cl", part, "-o", "x.apt", "--clear", "1e300"), WRONG_USAGE),
                              (("cl", part, "-o", "x.apt", "--spindle", "1e20"), WRONG_USAGE),
                              (("cl", part, "-o", "x.apt", "--feed", "1e-9"), BAD_INPUT),
                              (("cl", part, "-o", "x.apt", "--along", "sideways"), WRONG_USAGE),
                              (("cl", part, "-o", "x.apt", "--along", "u"), WRONG_USAGE),
                              (("cl", part, "-o", "x.apt", "--along", "u", "--method", "cc"), BAD_INPUT),
                              (("cl", part, "-o", "x.apt", "--cutter", "4,3"), WRONG_USAGE),
                              (("cl", part, "-o", "x.apt", "--cutter", "0,0"), WRONG_USAGE),
                              (("cl", part, "-o", "x.apt", "--interval", "1e-9"), WRONG_USAGE),
                              (("cl", part, "-o", "x.apt", "--cusp", "1e-30"), WRONG_USAGE),
                              (("cl", part, "-o", "x.apt", "--interval", "1", "--cusp", "1"), WRONG_USAGE)):
            done = self.run_program(*words, status=status)
            self.assertIn(b"error: ", done.stderr)
            self.assertFalse((self.folder / "x.apt").exists())
        # What cannot be is told where it stands: at the option, or in the part program.
        fine = self.write("fine.part", BALL.format(extra="CUTTER,6,3\nCUSP,3\n"))
        for words, status, told in ((("cl", part, "--interval", "1e-12"), WRONG_USAGE, b"diesink: error: --interval: "),
                                    (("cl", part, "--cusp", "5"), WRONG_USAGE, b"diesink: error: --cusp: "),
                                    (("cl", part, "--intol", "0", "--outtol", "0"), WRONG_USAGE, b"diesink: error: --intol: "),
                                    (("cl", fine), BAD_INPUT, b"fine.part: error: the cusp height ")):
            self.assertIn(told, self.run_program(*words, "-o", "x.apt", status=status).stderr)
        # Every ending that the message lists can be written.
        told = self.run_program("cl", part, "-o", "x.txt", status=WRONG_USAGE).stderr.decode()
        endings = re.findall(r"\.\w+", told.split("written:")[1])
        self.assertEqual({".apt", ".cldata", ".ngc", ".tap", ".csv"} - set(endings), set())
        self.run_program("cl", part, *(word for ending in endings for word in ("-o", "all" + ending)))
        self.write("bad.apt", "GOTO/1,2,3\nGOTO/1,oops,3\n")
        done = self.run_program("verify", part, "bad.apt", status=BAD_INPUT)
        self.assertIn(b"bad.apt:2:8: error: ", done.stderr)

    def test_same_bytes_for_any_threads(self):
        part = self.write("ball.part", MACHINED)
        for threads in (1, 2, 7):
            self.run_program("cl", part, "-o", f"{threads}.apt", "--threads", threads)
        self.assertEqual((self.folder / "1.apt").read_bytes(), (self.folder / "2.apt").read_bytes())
        self.assertEqual((self.folder / "1.apt").read_bytes(), (self.folder / "7.apt").read_bytes())

    def test_a_domain_up_to_the_rim_of_the_base_in_inches(self):
        inch = SOURCE / "fixtures/parts/inch.part"
        self.run_program("cl", inch, "--interval", "0.1", "-o", "inch.apt", "-o", "inch.ngc")
        self.assertIn("\nUNITS/INCHES\n", (self.folder / "inch.apt").read_text())
        self.assertIn("G17 G20 ", (self.folder / "inch.ngc").read_text())
        lengths = set()
        for name in ("inch.apt", "inch.ngc"):
            found = json.loads(self.run_program("verify", inch, name, "--json").stdout)
            self.assertLessEqual(found["max_gouge"] - found["bound"], 0.0005)
            self.assertEqual(found["rapid_plunges"], 0)
            lengths.add(round(found["length"], 3))
        self.assertEqual(len(lengths), 1)

    def test_fig6_within_its_tolerances(self):
        self.run_program("cl", FIG6, "--cutter", "6,3", "--cusp", "0.02", "-o", "fig6.apt")
        found = json.loads(self.run_program("verify", FIG6, "fig6.apt", "--cusp", "0.02", "--json").stdout)
        self.assertLessEqual(found["max_gouge"], 0.02 + found["bound"])
        self.assertLess(found["uncut_area"], 2)


class LinuxCnc(CommandLineTest):
    def test_canonical_moves_are_our_points(self):
        ready = interpreter()
        if ready is None:
            self.skipTest("rs274 is not there")
        program, environment = ready
        # Both tolerances give five decimals.
        for unit, cutter in itertools.product(("", "UNITS,INCH\n"), ("4,2", "4,0.8", "4,0")):
            part = self.write("ball.part", unit + MACHINED)
            self.run_program("cl", part, "--cutter", cutter, "-o", "a.ngc", "-o", "a.csv")
            self.write("tool.tbl", "T1 P1 Z0 D10\n")
            done = subprocess.run([program, "-t", "tool.tbl", "-g", "a.ngc"], cwd=self.folder, env=environment,
                                  capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 0, done.stderr[-2000:])
            moves = [(kind, *map(float, where.split(",")[:3]))
                     for kind, where in re.findall(r"STRAIGHT_(TRAVERSE|FEED)\(([^)]*)\)", done.stdout)]
            ours = []
            for line in (self.folder / "a.csv").read_text().splitlines():
                if line[0] in "#x":
                    continue
                x, y, z, motion = line.split(",")
                # G-code leaves out what is no move in its decimals.
                point = ("TRAVERSE" if motion == "rapid" else "FEED", *(round(float(v), 5) for v in (x, y, z)))
                if not ours or point[1:] != ours[-1][1:]:
                    ours.append(point)
            # The first move is the one up to the clearance plane. The interpreter prints four decimals.
            self.assertEqual(len(moves), len(ours) + 1)
            for (kind, *a), (motion, *b) in zip(moves[1:], ours):
                self.assertEqual(kind, motion)
                for p, q in zip(a, b):
                    self.assertAlmostEqual(p, q, delta=1.1e-4)

    def test_arcs_are_read_as_the_interpreter_reads_them(self):
        ready = interpreter()
        if ready is None:
            self.skipTest("rs274 is not there")
        program, environment = ready
        self.write("tool.tbl", "T1 P1 Z0 D10\n")
        paths = SOURCE / "fixtures/paths"
        for path in sorted(paths.glob("*.nc")):
            done = subprocess.run([program, "-t", "tool.tbl", "-g", path], cwd=self.folder, env=environment,
                                  capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 0, done.stderr[-2000:])
            unit = 25.4 if "CANON_UNITS_INCHES" in done.stdout else 1
            at, length, arcs = (0, 0, 0), 0, 0
            for kind, text in re.findall(r"(STRAIGHT_TRAVERSE|STRAIGHT_FEED|ARC_FEED)\(([^)]*)\)", done.stdout):
                v = [unit * float(word) for word in text.split(",")]
                if kind == "ARC_FEED":
                    to, center, turns = (v[0], v[1], v[5]), v[2:4], v[4] / unit
                    start, end = (math.atan2(p[1] - center[1], p[0] - center[0]) for p in (at, to))
                    angle = (end - start) % (2 * math.pi) if turns > 0 else (start - end) % (2 * math.pi)
                    flat = math.dist(at[:2], center) * (angle + 2 * math.pi * (abs(turns) - 1))
                    length += math.hypot(flat, to[2] - at[2])
                    arcs += 1
                else:
                    to = tuple(v[:3])
                    length += math.dist(at, to) if kind == "STRAIGHT_FEED" else 0
                at = to
            self.assertEqual(arcs, 2)
            found = json.loads(self.run_program("verify", paths / "boss.part", path, "--cutter", "6,0", "--json").stdout)
            # The interpreter prints four decimals.
            self.assertAlmostEqual(found["length"], length, delta=2e-4 * unit * 8, msg=path.name)


if __name__ == "__main__":
    unittest.main()
