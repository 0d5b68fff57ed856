#!/usr/bin/env python3
"""The manual page and the completions know what `--help` tells, and the tools they are for accept them."""
# SPDX-License-Identifier: Apache-2.0
import re
import shutil
import subprocess
import unittest

from program import WRONG_USAGE, CommandLineTest


class OptionPages(CommandLineTest):
    def text(self, *words):
        return self.run_program(*words).stdout.decode()

    def completions(self, *line):
        """What bash offers for a command line whose last word is being typed."""
        script = (self.text("--completion", "bash").replace("compopt -o filenames", ":")
                  + 'COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _diesink; printf "%s\\n" "${COMPREPLY[@]}"')
        done = subprocess.run(["bash", "-c", script, "bash", "diesink", *line], capture_output=True, cwd=self.folder,
                              check=True, text=True)
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    def test_every_option_is_in_every_page(self):
        commands = re.findall(r"^  ([a-z]+) ", self.text("--help"), re.M)
        self.assertGreater(len(commands), 5)
        bash, zsh, fish = (self.text("--completion", shell) for shell in ["bash", "zsh", "fish"])
        man = self.text("--man").replace("\\-", "-")
        for command in commands:
            section = re.search(rf"^\.SS {command}\n(.*?)(?=^\.S[SH]|\Z)", man, re.M | re.S)[1]
            in_zsh = re.search(rf"^    {command}\)\n(.*?);;$", zsh, re.M | re.S)[1]
            offered = self.completions(command, "-")
            options = re.findall(r"^  (?:-\w,)?(--[a-z-]+)", self.text(command, "--help"), re.M)
            self.assertIn("--help", options)
            for option in options:
                with self.subTest(command=command, option=option):
                    self.assertIn(option, offered)
                    self.assertRegex(section, rf"\\fB(-\w, )?{option}\\fR")
                    self.assertIn(f"'{option}[", in_zsh)
                    self.assertRegex(fish, rf"from {command}'( -s \w)? -l {option[2:]} ")
            self.assertIn(command, bash)

    def test_bash_completes_commands_words_and_files(self):
        self.assertEqual(self.completions("prev"), ["preview"])
        self.assertEqual(self.completions("preview", "--view", "p"), ["plan"])
        self.assertEqual(self.completions("export", "--format", "s"), ["stl"])
        self.assertEqual(self.completions("preview", "--si"), ["--size"])
        self.write("die.part", "")
        self.assertEqual(self.completions("preview", "die"), ["die.part"])

    def test_the_shells_and_groff_accept_them(self):
        for tool, words in [("groff", ["groff", "-man", "-ww", "-z"]), ("zsh", ["zsh", "-n"]), ("fish", ["fish", "-n"])]:
            if shutil.which(tool) is None:
                print(f"{tool} is not installed: its page is not checked")
                continue
            page = self.write(tool, self.text(*(["--man"] if tool == "groff" else ["--completion", tool])))
            done = subprocess.run([*words, str(page)], capture_output=True, check=False, text=True)
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""), tool)

    def test_unknown_shell(self):
        self.run_program("--completion", status=WRONG_USAGE)
        self.run_program("--completion", "csh", status=WRONG_USAGE)


if __name__ == "__main__":
    unittest.main()
