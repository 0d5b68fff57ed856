"""What the tests of the Python module share."""
# SPDX-License-Identifier: Apache-2.0
import os
import pathlib
import sys

import pytest

import diesink

SOURCE = pathlib.Path(os.environ["DIESINK_SOURCE_DIR"])
PARTS = SOURCE / "fixtures/parts"
sys.path.append(str(SOURCE / "tests/convert"))
import program  # noqa: E402

BALL = program.BALL.format(extra="X-INT,.5\nY-INT,.5\n")


@pytest.fixture(scope="session")
def ball():
    return diesink.parse(BALL, "ball.part")


@pytest.fixture(scope="session")
def fig6():
    return diesink.load(PARTS / "fig6.part")
