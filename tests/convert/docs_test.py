#!/usr/bin/env python3
"""The commands of README.md and docs/ run, and docs/command-line.md knows every command and option there is."""
# SPDX-License-Identifier: Apache-2.0
import os
import pathlib
import re
import subprocess
import unittest

from program import PROGRAM, SOURCE, CommandLineTest

REFERENCE = SOURCE / "docs/command-line.md"


def shell_blocks(path):
    return re.findall(r"^```sh\n(.*?)^```", path.read_text(), re.M | re.S)


def program_lines(path):
    """The lines of the page's shell blocks that call the program, in their order."""
    for block in shell_blocks(path):
        for line in block.splitlines():
            command = line.split("#")[0].strip().removeprefix("build/release/bin/")
            if command.startswith("diesink "):
                yield command


def commands():
    """Names of the subcommands, as the program lists them."""
    text = subprocess.run([PROGRAM, "--help"], capture_output=True, check=True, text=True).stdout
    return re.findall(r"^  ([a-z]+) ", text, re.M)


class Docs(CommandLineTest):
    def test_commands_run(self):
        pages = [SOURCE / "README.md", *sorted((SOURCE / "docs").glob("*.md"))]
        self.assertTrue(any(program_lines(page) for page in pages))
        path = f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}"
        for page in pages:
            # Each page's commands run one after the other in a folder like the checkout's.
            folder = self.folder / page.stem
            (folder / "out").mkdir(parents=True)
            (folder / "fixtures").symlink_to(SOURCE / "fixtures")
            (folder / "points.csv").write_text("x,y\n20,20\n10,30\n")
            for line in program_lines(page):
                with self.subTest(page=page.name, line=line):
                    done = subprocess.run(["sh", "-c", line], cwd=folder, env={**os.environ, "PATH": path},
                                          capture_output=True, timeout=120, check=False)
                    self.assertEqual(done.returncode, 0, done.stderr.decode(errors="replace")[:2000])

    def test_scripts_named_in_the_readme_are_there(self):
        blocks = "\n".join(shell_blocks(SOURCE / "README.md"))
        scripts = re.findall(r"^(scripts/\S+)", blocks, re.M)
        self.assertIn("scripts/demo.sh", scripts)
        self.assertIn("scripts/test.sh", scripts)
        for script in scripts:
            self.assertTrue(os.access(SOURCE / script, os.X_OK), script)

    def test_reference_knows_every_command_and_option(self):
        sections = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", REFERENCE.read_text(), re.M | re.S))
        shared = REFERENCE.read_text().split("\n## export")[0]
        for command in commands():
            self.assertIn(command, sections, "docs/command-line.md has no section for it")
            text = subprocess.run([PROGRAM, command, "--help"], capture_output=True, check=True, text=True).stdout
            for option in re.findall(r"^  (?:-\w,)?(--[a-z-]+)", text, re.M):
                self.assertRegex(sections[command] + shared, rf"`[^`]*{option}\b", f"{command} {option}")

    def test_links_lead_somewhere(self):
        for page in [SOURCE / "README.md", *(SOURCE / "docs").glob("*.md")]:
            for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text()):
                if "://" not in target:
                    self.assertTrue((page.parent / target).exists(), f"{page.name}: {target}")


if __name__ == "__main__":
    unittest.main()
