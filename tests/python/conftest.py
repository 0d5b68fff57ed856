"""What the tests of the Python module share."""
# SPDX-License-Identifier: Apache-2.0
import os
import pathlib

import pytest

import diesink

PARTS = pathlib.Path(os.environ["DIESINK_SOURCE_DIR"]) / "fixtures/parts"

# A plane with a hemisphere of radius 3 on it.
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
X-INT,.5
Y-INT,.5
"""


@pytest.fixture(scope="session")
def ball():
    return diesink.parse(BALL, "ball.part")


@pytest.fixture(scope="session")
def fig6():
    return diesink.load(PARTS / "fig6.part")
