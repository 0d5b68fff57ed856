#!/usr/bin/env python3
"""The commands of README.md and docs/ run, and docs/command-line.md knows every command and option there is."""
# SPDX-License-Identifier: Apache-2.0
import dataclasses
import os
import pathlib
import re
import subprocess
import unittest

from program import PROGRAM, SOURCE, CommandLineTest

REFERENCE = SOURCE / "docs/command-line.md"


PAGES = [SOURCE / "README.md", *sorted((SOURCE / "docs").glob("*.md"))]


@dataclasses.dataclass
class Block:
    """A fenced block: its language, the words after that, its text.

    ```sh              runs in a shell that stops at the first command that fails; `status=N` is the exit status it shall end with
    ```sh norun=WHY    is not run; the scripts it names are there
    ```LANG file=NAME  is written to NAME, for the commands that follow
    ```part            a part program without an error, where it is a whole one
    ```output          what the sh block before it says, stdout and stderr; `...` stands for any text in a line, or for any lines
    """

    line: int
    language: str
    words: dict
    text: str


def blocks_of(path):
    """The fenced blocks of a page in their order; those in a list may be indented."""
    found, opened = [], None
    for number, line in enumerate(path.read_text().splitlines(), 1):
        fence = re.match(r"( *)```(.*)", line)
        if opened is None and fence:
            language, *words = fence.group(2).split() or [""]
            words = dict(word.partition("=")[::2] for word in words)
            opened = Block(number, language, words, "")
            indent = len(fence.group(1))
        elif fence:
            found.append(opened)
            opened = None
        elif opened is not None:
            opened.text += line[indent:] + "\n"
    assert opened is None, f"{path}:{opened.line}: no end of the block"
    return found


def matches(said, wanted):
    """True where `said` is `wanted`, in which `...` stands for anything of a line and a line of it alone for any lines."""
    pattern = "".join(r"(?:.*\n)*?" if line.strip() == "..." else ".*".join(map(re.escape, line.split("..."))) + r"\n"
                      for line in wanted.splitlines())
    return re.fullmatch(pattern, said) is not None


class Page:
    """Runs the blocks of one page in a folder like the checkout's."""

    def __init__(self, path, folder):
        self.path, self.folder = path, folder
        (folder / "out").mkdir(parents=True)
        (folder / "build/release").mkdir(parents=True)
        (folder / "build/release/bin").symlink_to(pathlib.Path(PROGRAM).parent)
        for name in ("fixtures", "docs", "scripts"):
            (folder / name).symlink_to(SOURCE / name)
        (folder / "points.csv").write_text("x,y\n20,20\n10,30\n")
        self.environment = {**os.environ, "PATH": f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}", "NO_COLOR": "1"}
        self.said = None

    def fault(self, block):
        """What is wrong with the block; None where all is well."""
        if "file" in block.words:
            (self.folder / block.words["file"]).write_text(block.text)
        if block.language == "sh":
            return self.fault_of_scripts(block) if "norun" in block.words else self.fault_of_commands(block)
        if block.language == "output":
            return None if matches(self.said, block.text) else f"says\n{self.said}instead of\n{block.text}"
        if block.language == "part" and "BOOLE-DEF" in block.text and "file" not in block.words:
            done = subprocess.run([PROGRAM, "info", "-"], input=block.text.encode(), capture_output=True, timeout=60, check=False)
            return done.stderr.decode(errors="replace") if done.returncode else None
        return None

    def fault_of_commands(self, block):
        done = subprocess.run(["sh", "-ec", block.text], cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120, check=False)
        self.said = done.stdout.decode(errors="replace")
        wanted = int(block.words.get("status", 0))
        return None if done.returncode == wanted else f"ends with {done.returncode}, not {wanted}:\n{self.said[:2000]}"

    def fault_of_scripts(self, block):
        scripts = re.findall(r"\bscripts/[\w.]+", block.text)
        lost = [name for name in scripts if not os.access(SOURCE / name, os.X_OK)]
        if lost:
            return f"no {', '.join(lost)}"
        return None if block.words["norun"] else "norun needs a reason"


def commands():
    """Names of the subcommands, as the program lists them."""
    text = subprocess.run([PROGRAM, "--help"], capture_output=True, check=True, text=True).stdout
    return re.findall(r"^  ([a-z]+) ", text, re.M)


class Docs(CommandLineTest):
    def test_commands_run(self):
        for path in PAGES:
            page = Page(path, self.folder / f"{path.parent.name}-{path.stem}")
            for block in blocks_of(path):
                with self.subTest(page=path.name, line=block.line):
                    self.assertIsNone(page.fault(block))

    def test_every_block_says_what_it_is(self):
        languages = {"sh", "output", "part", "text", "cpp", "cmake", "python", "c", "json"}
        for path in PAGES:
            for block in blocks_of(path):
                self.assertIn(block.language, languages, f"{path.name}:{block.line}")
            for number, line in enumerate(path.read_text().splitlines(), 1):
                self.assertNotRegex(line, r"^ {4,}(diesink|scripts/\S+|cmake|ctest) ", f"{path.name}:{number}: a command outside ```sh")

    def test_scripts_and_files_named_are_there(self):
        for path in PAGES:
            for name in re.findall(r"`((?:scripts|docs|fixtures|tests|core|formats|convert|picture|python|bench)/[\w./-]+)", path.read_text()):
                whole = SOURCE / name.rstrip("./")
                self.assertTrue(whole.exists() or list(whole.parent.glob(whole.name + "*")), f"{path.name}: {name}")

    def test_the_example_is_the_file_of_the_examples(self):
        shown = [b for path in PAGES for b in blocks_of(path) if b.words.get("file") == "lid.part"]
        self.assertEqual([b.text for b in shown], [(SOURCE / "docs/examples/lid.part").read_text()])

    def test_output_may_leave_something_open(self):
        self.assertTrue(matches("a 1 b\nc\nd\n", "a ... b\n...\nd\n"))
        self.assertTrue(matches("a\n", "a\n...\n"))
        self.assertFalse(matches("a\nb\n", "a\n"))
        self.assertFalse(matches("a.b\n", "a+b\n"))

    def test_reference_knows_every_command_and_option(self):
        sections = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", REFERENCE.read_text(), re.M | re.S))
        shared = REFERENCE.read_text().split("\n## export")[0]
        for command in commands():
            self.assertIn(command, sections, "docs/command-line.md has no section for it")
            text = subprocess.run([PROGRAM, command, "--help"], capture_output=True, check=True, text=True).stdout
            for option in re.findall(r"^  (?:-\w,)?(--[a-z-]+)", text, re.M):
                self.assertRegex(sections[command] + shared, rf"`[^`]*{option}\b", f"{command} {option}")

    def test_links_lead_somewhere(self):
        for page in PAGES:
            for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text()):
                if "://" not in target:
                    self.assertTrue((page.parent / target).exists(), f"{page.name}: {target}")


if __name__ == "__main__":
    unittest.main()
