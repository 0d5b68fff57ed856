"""Drives the built program: what every command line test starts from."""
# SPDX-License-Identifier: Apache-2.0
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

PROGRAM = os.environ["DIESINK_PROGRAM"]
SOURCE = pathlib.Path(os.environ["DIESINK_SOURCE_DIR"])
FIG6 = SOURCE / "fixtures/parts/fig6.part"
ALLPRIMS = SOURCE / "fixtures/parts/allprims.part"

DONE, WRONG_USAGE, BAD_INPUT, NOT_IN_BUILD, NOT_WRITTEN, NOT_KEPT = range(6)

# A plane with a hemisphere on it; `extra` goes into the machining section.
BALL = """SOLID-DEF
S1,SPHER,1
P1,5,5,0
RAD,3
BSURF-DEF
PLANE,0
BOOLE-DEF
B+S1
MACHI-DEF
X-RNG,0,10
Y-RNG,0,10
{extra}"""


def has_viewer():
    """False, with a line that says so, for a build without esbuild or three.js."""
    built = subprocess.run([PROGRAM, "view", os.devnull, "-o", "-"], capture_output=True, check=False).returncode != NOT_IN_BUILD
    if not built:
        print("this build has no viewer: its pages are not tested")
    return built


class CommandLineTest(unittest.TestCase):
    """Each test has an empty folder of its own, self.folder, as working folder."""

    maxDiff = 2000

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="diesink-test-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def run_program(self, *words, status=DONE, stdin=None, env=None, **options):
        """Runs the program; fails unless it ends with `status`, or one of them. Gives stdout and stderr as bytes in .stdout, .stderr."""
        done = subprocess.run([PROGRAM, *map(str, words)], input=stdin, capture_output=True, cwd=self.folder, timeout=120,
                              stdin=subprocess.DEVNULL if stdin is None else None,
                              env={**os.environ, **(env or {})}, **options)
        self.assertIn(done.returncode, status if isinstance(status, tuple) else (status,),
                      f"{words}\nstdout: {done.stdout[:2000]}\nstderr: {done.stderr.decode(errors='replace')[:4000]}")
        return done

    def write(self, name, text):
        path = self.folder / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    def files(self):
        """Names of everything in the working folder, hidden files too."""
        return sorted(p.name for p in self.folder.iterdir())

    def interrupt_while_writing(self, *words, sent=signal.SIGINT):
        """Sends a signal once a file of some size appears in the working folder; gives the way the program ended."""
        before = set(self.files())
        process = subprocess.Popen([PROGRAM, *map(str, words)], cwd=self.folder, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        try:
            deadline = time.monotonic() + 60
            while not any(p.stat().st_size > 0 for p in self.folder.iterdir() if p.name not in before):
                self.assertIsNone(process.poll(), "ended before it could be interrupted")
                self.assertLess(time.monotonic(), deadline, "no file appeared")
                time.sleep(0.001)
            process.send_signal(sent)
            return process.wait(timeout=60)
        finally:
            process.kill()
            process.wait()


def limited_file_size(size):
    """For preexec_fn: files may not grow beyond `size` bytes, as on a full disk."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
