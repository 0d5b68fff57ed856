"""What the soaks share: runs with a limit of processor time, and seeds shared out among the cores."""
# SPDX-License-Identifier: Apache-2.0
import argparse
import concurrent.futures
import dataclasses
import os
import pathlib
import resource
import signal
import subprocess
import tempfile

LIMIT = 60  # seconds of processor time of one run


def run(*words, limit=LIMIT):
    """(status, stdout, stderr, seconds of processor time); the status is None where it takes more than the limit."""
    limit = int(limit)
    with tempfile.TemporaryFile("w+", errors="replace") as out, tempfile.TemporaryFile("w+", errors="replace") as err:
        child = subprocess.Popen([str(w) for w in words], stdout=out, stderr=err,
                                 preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1)))
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        said, complained, seconds = out.read(), err.read().strip(), used.ru_utime + used.ru_stime
    if child.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        return None, "", f"does not end in {limit} s", seconds
    return child.returncode, said, complained, seconds


@dataclasses.dataclass
class Look:
    """What one seed has shown; lines that begin with "refused" or "passed over" count as not looked at."""
    name: str
    files: list  # of it, kept where there is something to tell
    failed: bool = False
    lines: list = dataclasses.field(default_factory=list)


def options_of(doc, kinds, slow):
    """The command line of a soak. `slow`: seconds from which on a run is told."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=kinds)
    parser.add_argument("first", type=int)
    parser.add_argument("count", type=int)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("build/soak"))
    parser.add_argument("--slow", type=float, default=slow, help=f"seconds of processor time from which on a run is told ({slow})")
    parser.add_argument("--lanes", type=int, default=os.cpu_count(), help="seeds at a time")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    return options


def soak(look_at, what, options):
    """Looks at each seed by look_at(seed, options), tells what there is to tell and the counts; 1 where one failed."""
    failures = told = passed_over = 0
    with concurrent.futures.ThreadPoolExecutor(options.lanes) as lanes:
        seeds = range(options.first, options.first + options.count)
        for look in lanes.map(lambda seed: look_at(seed, options), seeds):
            failures += look.failed
            told += any(" tells " in line for line in look.lines)
            passed_over += any(line.startswith(("refused", "passed over")) for line in look.lines)
            for line in look.lines:
                print(f"{look.name}: {'BAD ' if look.failed else ''}{line}", flush=True)
            if not look.lines:
                for file in look.files:
                    file.unlink()
    print(f"{options.count} {what} ({options.kind}): {failures} failed, {told} tell an area, {passed_over} not looked at")
    return 1 if failures else 0
