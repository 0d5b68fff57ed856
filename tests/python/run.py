"""Runs pytest over a folder; ends with 77 and a line that says so where pytest or numpy is not installed."""
# SPDX-License-Identifier: Apache-2.0
import importlib.util
import sys

missing = [name for name in ("numpy", "pytest") if importlib.util.find_spec(name) is None]
if missing:
    print(f"SKIPPED: {sys.executable} has no {' and no '.join(missing)} (Debian: python3-numpy python3-pytest)")
    sys.exit(77)

import pytest  # noqa: E402

sys.exit(pytest.main(["-q", "-p", "no:cacheprovider", *sys.argv[1:]]))
