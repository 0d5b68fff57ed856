#!/usr/bin/env python3
"""Exports and proves random dies of make_dies.py; tells what fails, takes long or is not certified, and keeps those.

  soak_dies.py aligned|rounded|fine FIRST COUNT [--build build/release] [--folder build/soak] [--slow SECONDS]

Each die is exported by the program (adaptive, every third in tiles, too), with a limit of 60 s, and proven as a sheet,
a solid and a grid by `tessellation_soak --part`. Ends with 1 where a proof fails, the program crashes or does not end."""
# SPDX-License-Identifier: Apache-2.0
import json
import pathlib
import sys
import tempfile

import make_dies
from soak import Look, options_of, run, soak


def look_at(seed, options):
    part = make_dies.write(options.kind, seed, options.folder)
    look = Look(part.name, [part])
    with tempfile.TemporaryDirectory() as folder:
        export = [options.build / "bin/diesink", "export", part, "-o", pathlib.Path(folder) / "die.ply", "--json",
                  "--threads", 1]
        for way in [[], ["--tiles", "2x3"]][:2 if seed % 3 == 0 else 1]:
            status, out, err, seconds = run(*export, *way)
            name = " ".join(["export", *way])
            # Six decimals are not always a plane, and what is drawn may miss the domain.
            if status == 2 and ("not planar" in err or "nothing to tessellate" in err):
                look.lines.append(f"refused: {err.splitlines()[0]}")
                return look
            if status not in (0, 5):
                look.failed = True
                look.lines.append(f"{name} ends with {status}: {err[:300]}")
            elif status == 5:
                look.lines.append(f"{name} tells {json.loads(out)['uncertified_area']:.3g} mm2")
            if seconds > options.slow and status is not None:
                look.lines.append(f"{name} takes {seconds:.1f} s")
    status, out, err, _ = run(options.build / "bin/tessellation_soak", "--part", part)
    if status != 0:
        look.failed = True
        look.lines.append(f"proof ends with {status}: " + (out + err)[:600])
    return look


if __name__ == "__main__":
    sys.exit(soak(look_at, "dies", options_of(__doc__, make_dies.KINDS, slow=3)))
