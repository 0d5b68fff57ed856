"""Puts a table of figures into a page, in the place of the one before."""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import re


def markdown(rows):
    """A table of rows of words; the first is its head, and every column but the first is right-aligned."""
    head, *others = [" | ".join(row) for row in rows]
    rule = " | ".join(["---"] + ["--:"] * (len(rows[0]) - 1))
    return "".join(f"| {line} |\n" for line in [head, rule, *others])


def replace(page, name, text):
    """The lines of `page` between `<!-- name -->` and `<!-- end -->` become `text`."""
    page = pathlib.Path(page)
    old = page.read_text()
    new, count = re.subn(rf"(<!-- {name} -->\n).*?(<!-- end -->\n)", lambda found: found[1] + text + found[2], old, flags=re.S)
    if count != 1:
        raise SystemExit(f"{page}: expected one place <!-- {name} --> ... <!-- end -->, found {count}")
    page.write_text(new)
