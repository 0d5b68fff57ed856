#!/usr/bin/env python3
"""The command line as a whole: help, options, exit status, messages, and info, cc and formats."""
# SPDX-License-Identifier: Apache-2.0
import csv
import io
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import unittest

from program import (ALLPRIMS, BAD_INPUT, BALL, DONE, FIG6, NOT_WRITTEN, PROGRAM, SOURCE, WRONG_USAGE, CommandLineTest,
                     limited_file_size)

COMMANDS = ["export", "cc", "cl", "verify", "convert", "info", "preview", "view", "formats"]


class Help(CommandLineTest):
    def commands(self):
        lines = self.run_program("--help").stdout.decode().splitlines()
        return [line.split()[0] for line in lines if line.startswith("  ") and not line.startswith("   ")
                and not line.lstrip().startswith("-")]

    def test_overview_fits_a_screen(self):
        lines = self.run_program("--help").stdout.decode().splitlines()
        self.assertLessEqual(len(lines), 23)  # a prompt below it in a terminal of 24
        self.assertLessEqual(max(map(len, lines)), 80)
        for command in self.commands():
            self.assertIn(command, COMMANDS)

    def test_every_command_has_an_example_and_the_common_options(self):
        for command in self.commands():
            text = self.run_program(command, "--help").stdout.decode()
            self.assertIn(f"Example:\n  diesink {command}", text)
            self.assertIn("--threads", text)
            self.assertIn("--quiet", text)

    def test_version(self):
        self.assertRegex(self.run_program("--version").stdout, rb"^diesink \d+\.\d+\.\d+\n$")


class Usage(CommandLineTest):
    def message(self, *words):
        done = self.run_program(*words, status=WRONG_USAGE)
        return done.stderr.decode()

    def test_no_command(self):
        self.assertIn("command is missing", self.message())

    def test_unknown_command_suggests_the_nearest(self):
        self.assertIn("did you mean 'info'", self.message("inof", FIG6))
        self.assertNotIn("did you mean", self.message("zzzzzzzz"))

    def test_unknown_option_suggests_the_nearest(self):
        self.assertIn("did you mean '--edges'", self.message("cc", FIG6, "-o", "x.csv", "--egdes", "e.csv"))
        self.assertIn("did you mean '--json'", self.message("info", FIG6, "--jsno"))

    def test_missing_and_superfluous_arguments(self):
        self.assertIn("FILE", self.message("info"))
        self.assertIn("'b.part'", self.message("info", FIG6, "b.part"))
        self.assertIn("--output", self.message("cc", FIG6))

    def test_numbers_are_decimal_and_finite(self):
        for word in ["nan", "inf", "0x10", "1e2", "-3", "+4", "", " 4", "4 ", "4.0", "99999999999999999999", "0", "1025"]:
            self.assertIn("--threads", self.message("formats", "--threads", word))
        for word in ["1", "010", "1024"]:  # 010 is ten, not an octal eight
            self.run_program("formats", "--threads", word)

    def test_two_answers_for_stdout(self):
        self.assertIn("stdout", self.message("cc", FIG6, "-o", "-", "--json"))

    def test_unknown_ending(self):
        self.assertIn(".csv .json", self.message("cc", FIG6, "-o", "out.cvs"))
        self.assertEqual(self.files(), [])


class Info(CommandLineTest):
    def test_boolean_table_of_the_paper(self):
        text = self.run_program("info", FIG6).stdout.decode()
        rows = [line.split() for line in text.split("sign\n")[1].splitlines()[1:]]
        self.assertEqual(rows, [["0", "B", "FERGU", "+"], ["1", "S2", "R-CYLI", "+"], ["2", "S3", "SPHER", "+"],
                                ["3", "S5", "4-PRIS", "+"], ["4", "S7", "4-PRIS", "-"], ["5", "S8", "E-CONE", "+"],
                                ["6", "S9", "R-CYLI", "-"]])
        self.assertIn("B+S2+S3+S5-S7+S8-S9", text)

    def test_json(self):
        told = json.loads(self.run_program("info", FIG6, "--json").stdout)
        self.assertEqual(list(told)[:6], ["solids", "boole", "base", "domain", "grid", "warnings"])
        self.assertEqual(told["boole"][4], {"row": 4, "id": "S7", "type": "4-PRIS", "sign": "-"})
        self.assertEqual(told["domain"], [1, 39, 1, 39])
        self.assertEqual(told["grid"], [49, 49])
        self.assertEqual(told["warnings"], [])
        self.assertEqual([each["id"] for each in told["solids"]], ["S2", "S3", "S5", "S7", "S8", "S9"])

    def test_groups_keep_their_parentheses(self):
        part = BALL.format(extra="").replace("B+S1", "B+(S1-S1)-S1+((S1)+S1)")
        told = json.loads(self.run_program("info", self.write("g.part", part), "--json").stdout)
        self.assertEqual(told["expression"], "B+(S1-S1)-S1+((S1)+S1)")

    def test_warnings_are_told_and_kept(self):
        part = BALL.format(extra="").replace("BSURF-DEF", "S2,SPHER,1\nP1,1,1,1\nRAD,1\nBSURF-DEF")
        done = self.run_program("info", self.write("w.part", part), "--json")
        self.assertIn(b"w.part:5:", done.stderr)
        self.assertIn(b"warning:", done.stderr)
        self.assertEqual(len(json.loads(done.stdout)["warnings"]), 1)

    def test_names_that_are_not_utf8_still_give_json(self):
        path = self.folder.as_posix().encode() + b"/\xff\xe9.part"
        with open(path, "wb") as file:
            file.write(BALL.format(extra="").replace("+S1", "").encode())
        done = self.run_program("info", path.decode(errors="surrogateescape"), "--json")
        json.loads(done.stdout.decode("utf-8"))


class CcData(CommandLineTest):
    HEADER = ["x", "y", "z", "nx", "ny", "nz", "surface", "row", "face"]

    def rows(self, text):
        return list(csv.reader(io.StringIO(text.decode())))

    def test_grid_and_edges(self):
        self.run_program("cc", FIG6, "-o", "cc.csv", "--edges", "edges.csv")
        rows = self.rows((self.folder / "cc.csv").read_bytes())
        self.assertEqual(rows[0], self.HEADER)
        self.assertEqual(len(rows), 1 + 49 * 49)
        edges = self.rows((self.folder / "edges.csv").read_bytes())
        self.assertEqual({row[0] for row in edges[1:]}, {"crease", "jump"})
        self.assertEqual(self.files(), ["cc.csv", "edges.csv"])

    def test_json_of_grid_and_edges(self):
        told = json.loads(self.run_program("cc", FIG6, "-o", "cc.json", "--edges", "e.json", "--json").stdout)
        points = json.loads((self.folder / "cc.json").read_text())["points"]
        edges = json.loads((self.folder / "e.json").read_text())["edges"]
        self.assertEqual(told["points"], len(points))
        self.assertEqual(sum(told["edges"].values()), len(edges))

    def test_points_from_stdin_and_file(self):
        points = b"x,y\n20,20\n99,99\n"
        rows = self.rows(self.run_program("cc", FIG6, "--at", "-", "-o", "-", stdin=points).stdout)
        # The cone S8 cut by the cylinder S9, whose lower end is at 14.
        self.assertEqual(rows[1], ["20", "20", "14", "0", "0", "1", "6", "6", "2"])
        self.assertEqual(rows[2], ["99", "99", "", "", "", "", "", "", ""])
        file = self.write("points.csv", points)
        self.assertEqual(rows, self.rows(self.run_program("cc", FIG6, "--at", file, "-o", "-").stdout))

    def test_bad_points(self):
        done = self.run_program("cc", FIG6, "--at", "-", "-o", "out.csv", stdin=b"1,1\n2,x\n", status=BAD_INPUT)
        self.assertIn(b"stdin:2:3: error:", done.stderr)
        self.assertEqual(self.files(), [])

    def test_part_program_from_stdin(self):
        one = self.run_program("cc", FIG6, "-o", "-").stdout
        self.assertEqual(one, self.run_program("cc", "-", "-o", "-", stdin=FIG6.read_bytes()).stdout)

    def test_same_bytes_for_any_thread_count_and_line_ending(self):
        crlf = self.write("crlf.part", FIG6.read_bytes().replace(b"\n", b"\r\n"))
        told = {self.run_program("cc", part, "-o", "-", "--threads", threads).stdout
                for part, threads in [(FIG6, 1), (FIG6, 2), (FIG6, 7), (crlf, 2)]}
        self.assertEqual(len(told), 1)
        edges = set()
        for threads in [1, 2, 7]:
            self.run_program("cc", ALLPRIMS, "-o", "cc.csv", "--edges", "e.csv", "--threads", threads)
            edges.add((self.folder / "e.csv").read_bytes())
        self.assertEqual(len(edges), 1)


class DecimalComma(CommandLineTest):
    """A locale that writes 1,5 changes nothing."""

    def test_same_bytes(self):
        made = subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", self.folder / "de_DE.UTF-8"],
                              capture_output=True, check=False) if shutil.which("localedef") else None
        if made is None or not (self.folder / "de_DE.UTF-8").is_dir():
            print("skipped: no localedef or no sources of de_DE (Debian package locales)", file=sys.stderr)
            self.skipTest("no locale with a decimal comma")
        comma = {"LC_ALL": "de_DE.UTF-8", "LOCPATH": str(self.folder)}
        shown = subprocess.run(["printf", "%.1f", "1,5"], env=comma, capture_output=True, check=True).stdout
        self.assertEqual(shown, b"1,5", "the locale is not in force")
        for words in [["cc", FIG6, "-o", "-"], ["info", FIG6], ["info", FIG6, "--json"]]:
            self.assertEqual(self.run_program(*words, env=comma).stdout,
                             self.run_program(*words, env={"LC_ALL": "C"}).stdout)


class Inputs(CommandLineTest):
    def test_message_has_place_and_caret(self):
        part = self.write("bad.part", BALL.format(extra="").replace("SPHER", "SPHRE"))
        lines = self.run_program("cc", part, "-o", "x.csv", status=BAD_INPUT).stderr.decode().splitlines()
        self.assertRegex(lines[0], r"bad\.part:2:4: error: .*SPHER")
        self.assertEqual(lines[1].index("SPHRE"), lines[2].index("^"))
        self.assertEqual(self.files(), ["bad.part"])

    def test_no_colour_unless_a_terminal(self):
        part = self.write("bad.part", "BOOLE-DEF\nB\n")
        self.assertNotIn(b"\x1b", self.run_program("info", part, status=BAD_INPUT).stderr)

    def test_files_that_cannot_be_read(self):
        for name in ["missing.part", ".", "/dev/null"]:
            self.run_program("info", name, status=BAD_INPUT)

    def test_broken_part_programs(self):
        broken = sorted((SOURCE / "fixtures/broken").glob("*.part"))
        self.assertGreaterEqual(len(broken), 60)
        for part in broken:
            with self.subTest(part.name):
                done = self.run_program("cc", part, "-o", "out.csv", "--json", status=BAD_INPUT)
                self.assertRegex(done.stderr.decode(errors="replace"), r"\.part(:\d+)*: error: ")
                self.assertEqual(done.stdout, b"")
                self.assertEqual(self.files(), [])


class Outputs(CommandLineTest):
    def big_part(self):
        return self.write("big.part", BALL.format(extra="X-INT,.002\nY-INT,.01\n"))

    def test_missing_folder(self):
        done = self.run_program("cc", FIG6, "-o", "none/x.csv", status=NOT_WRITTEN)
        self.assertIn(b"none/x.csv", done.stderr)
        done = self.run_program("cc", FIG6, "-o", self.write("file", "") / "x.csv", status=NOT_WRITTEN)

    def test_full_disk_leaves_nothing(self):
        done = self.run_program("cc", FIG6, "-o", "x.csv", status=NOT_WRITTEN, preexec_fn=limited_file_size(1000))
        self.assertIn(b"x.csv", done.stderr)
        self.assertEqual(self.files(), [])

    def test_full_disk_keeps_what_was_there(self):
        self.write("x.csv", "precious")
        self.run_program("cc", FIG6, "-o", "x.csv", status=NOT_WRITTEN, preexec_fn=limited_file_size(1000))
        self.assertEqual((self.folder / "x.csv").read_text(), "precious")
        self.assertEqual(self.files(), ["x.csv"])

    def test_second_output_fails_and_neither_appears(self):
        self.run_program("cc", FIG6, "-o", "x.csv", "--edges", "/dev/full", status=WRONG_USAGE)
        (self.folder / "e.csv").mkdir()
        self.run_program("cc", FIG6, "-o", "x.csv", "--edges", "e.csv", status=NOT_WRITTEN)
        self.assertEqual(self.files(), ["e.csv"])

    def test_two_outputs_in_one_place_are_refused(self):
        (self.folder / "in").mkdir()
        (self.folder / "way").symlink_to("in")
        for words in [["cc", FIG6, "-o", "x.csv", "--edges", "./x.csv"], ["export", FIG6, "-o", "a.stl", "./a.stl"],
                      ["export", FIG6, "-o", "in/a.stl", "--report", "way/a.stl"]]:
            done = self.run_program(*words, status=WRONG_USAGE)
            self.assertIn(b"named before", done.stderr)
        self.assertEqual(self.files(), ["in", "way"])
        self.assertEqual(list((self.folder / "in").iterdir()), [])
        # Two devices are no two files in one place.
        self.run_program("export", FIG6, "-o", "a.stl", "--report", "/dev/null", "--quiet")

    def test_content_decides_over_the_ending(self):
        self.run_program("export", FIG6, "-o", "a.stl", "--quiet")
        (self.folder / "a.stl").rename(self.folder / "a.part")
        self.assertEqual(json.loads(self.run_program("info", "a.part", "--json").stdout)["format"], "stl")
        self.assertIn("--solid: 'abc' is not", self.run_program("export", FIG6, "-o", "b.stl", "--solid=abc",
                                                                status=WRONG_USAGE).stderr.decode())

    def test_full_stdout(self):
        with open("/dev/full", "wb") as full:
            for words in [["formats"], ["--help"], ["info", FIG6], ["cc", FIG6, "-o", "-"]]:
                done = subprocess.run([PROGRAM, *map(str, words)], stdout=full, stderr=subprocess.PIPE, check=False)
                self.assertEqual(done.returncode, NOT_WRITTEN, words)
                self.assertIn(b"No space left", done.stderr)

    def test_interrupted_write_leaves_nothing(self):
        part = self.big_part()
        for sent in [signal.SIGINT, signal.SIGTERM]:
            ended = self.interrupt_while_writing("cc", part, "-o", "x.csv", sent=sent)
            self.assertEqual(ended, -sent)
            self.assertEqual(self.files(), [part.name])

    def terminal(self):
        try:
            return os.openpty()
        except OSError as why:  # a chroot without /dev/pts
            self.skipTest(f"no pseudo-terminal here: {why}")

    def on_terminal(self, *words, seconds):
        """Runs the program with a terminal as stderr and a stdout that nobody reads for some time; gives its stderr."""
        ours, theirs = self.terminal()
        process = subprocess.Popen([PROGRAM, *map(str, words)], cwd=self.folder, stderr=theirs, stdout=subprocess.PIPE)
        os.close(theirs)
        time.sleep(seconds)
        process.stdout.read()
        process.stdout.close()
        written = b""
        try:
            while piece := os.read(ours, 4096):
                written += piece
        except OSError:  # the other end is closed
            pass
        os.close(ours)
        self.assertEqual(process.wait(timeout=60), DONE)
        return written

    def test_progress_on_a_terminal_after_a_second(self):
        # More than a pipe holds: the program waits for its reader.
        words = ["cc", FIG6, "-o", "-"]
        self.assertRegex(self.on_terminal(*words, seconds=2), rb"\rwriting - \[#+\.*\] \d+ %, ")
        self.assertEqual(self.on_terminal(*words, "--quiet", seconds=2), b"")
        begun = time.monotonic()
        at_once = self.on_terminal(*words, seconds=0)
        if time.monotonic() - begun < 1:  # a loaded machine may take longer
            self.assertEqual(at_once, b"")

    def test_progress_tells_rate_and_time_left(self):
        ours, theirs = self.terminal()
        words = ["cl", FIG6, "--cutter", "6,3", "--cusp", "0.02", "--threads", "1", "-o", "x.apt", "--json"]
        process = subprocess.Popen([PROGRAM, *map(str, words)], cwd=self.folder, stderr=theirs, stdout=subprocess.DEVNULL)
        os.close(theirs)
        # Held up, the work lasts over a second on any machine.
        time.sleep(0.3)
        process.send_signal(signal.SIGSTOP)
        time.sleep(1.2)
        process.send_signal(signal.SIGCONT)
        written = b""
        try:
            while piece := os.read(ours, 4096):
                written += piece
        except OSError:  # the other end is closed
            pass
        os.close(ours)
        self.assertEqual(process.wait(timeout=60), DONE)
        self.assertRegex(written.decode(), r"\rplanning \[#*\.*\] \d+ %, \d+\.\d %/s, \d+ s left\x1b\[K")

    def test_upper_case_ending(self):
        self.run_program("cc", FIG6, "-o", "x.CSV", status=DONE)
        self.assertEqual(self.files(), ["x.CSV"])


if __name__ == "__main__":
    unittest.main()
