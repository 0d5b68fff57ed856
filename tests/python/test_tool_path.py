"""Tool paths: planned, as arrays, in files, verified."""
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

import diesink

CUTTER = (2, 1)


@pytest.fixture(scope="module")
def path(ball):
    return ball.cl(cutter=CUTTER, cusp=0.05)


def test_a_ball_cutter_keeps_its_distance(path):
    # Tips over the ball: the cutter's centre is radius + 3 away from the ball's centre, or farther.
    centres = path.tips + [0, 0, 1]
    distance = np.linalg.norm(centres[~path.rapid] - [5, 5, 0], axis=1)
    assert distance.min() == pytest.approx(4, abs=0.02)
    assert path.kept and path.cutter == CUTTER and path.unit == "mm" and path.feed == 1000
    assert len(path) == len(path.tips) == len(path.rapid) == path.report["points"]
    assert path.rapid[0] and not path.rapid.all()
    with pytest.raises(ValueError):
        path.tips[0, 0] = 1


def test_verify_finds_it_good_and_a_lowered_one_gouged(ball, path):
    good = ball.verify(path)
    assert good.kept and good.report["max_gouge"] <= 0.02
    assert good.height.shape == good.state.shape and (good.state <= 3).all()
    low = diesink.ToolPath(path.tips - [0, 0, 0.5], path.rapid, cutter=CUTTER)
    bad = ball.verify(low)
    assert not bad.kept
    assert bad.report["max_gouge"] == pytest.approx(0.5, abs=0.03)
    assert bad.height.min() < -0.4


def test_a_path_in_inches_is_the_same_path(ball, path):
    inches = diesink.ToolPath(path.tips / 25.4, path.rapid, cutter=(2 / 25.4, 1 / 25.4), unit="inch",
                              intol=path.intol / 25.4, outtol=path.outtol / 25.4)
    ours, theirs = ball.verify(path, spacing=0.1).report, ball.verify(inches, spacing=0.1).report
    assert theirs["max_gouge"] == pytest.approx(ours["max_gouge"], abs=1e-9)
    assert theirs["cusp_max"] == pytest.approx(ours["cusp_max"], abs=1e-6)


@pytest.mark.parametrize("ending", [".apt", ".ngc", ".csv"])
def test_files_give_the_path_back(path, tmp_path, ending):
    file = tmp_path / ("path" + ending)
    path.write(file)
    again, warnings = diesink.read_path(file)
    assert not warnings
    cut, want = again.tips[~again.rapid], path.tips[~path.rapid]
    # G-code leaves out moves that its digits make no moves at all; every tip is still met.
    np.testing.assert_allclose(cut[[0, -1]], want[[0, -1]], atol=1e-4)
    nearest = np.linalg.norm(want[:, None] - cut[None, :], axis=-1).min(axis=1)
    assert nearest.max() < 1e-4
    assert len(cut) == len(want) or ending == ".ngc"


def test_method_cc_gives_its_contacts(ball):
    path = ball.cl(cutter=CUTTER, method="cc", interval=1.0, along="y")
    points, normals = path.contacts[len(path.contacts) // 2]
    assert points.shape == normals.shape and points.shape[1] == 3
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-9)
    np.testing.assert_allclose(ball.evaluate(points[:, 0], points[:, 1]).z, points[:, 2], atol=1e-9)
    assert len(path.contacts) == path.report["passes"]


def test_what_is_wrong_is_told(ball, path, tmp_path):
    for wrong in ({}, {"cutter": (2, 3)}, {"cutter": CUTTER, "interval": 1, "cusp": 0.1}, {"cutter": CUTTER, "along": "z"},
                  {"cutter": CUTTER, "along": "u"}, {"cutter": CUTTER, "interval": -1}, {"cutter": CUTTER, "method": "fast"},
                  {"cutter": (1e300, 1)}, {"cutter": CUTTER, "clear": 1e300}, {"cutter": CUTTER, "feed": 1e10}):
        with pytest.raises(diesink.Error):
            ball.cl(**wrong)
    with pytest.raises(diesink.Error, match="ending"):
        path.write(tmp_path / "path.txt")
    with pytest.raises(diesink.Error, match="cutter"):
        ball.verify(diesink.ToolPath([[0, 0, 9], [1, 0, 9]]))
    with pytest.raises(diesink.Error, match="shape"):
        diesink.ToolPath([[0, 0]])
    (tmp_path / "arc.ngc").write_text("G21 G90\nG2 X1 Y1 I1 J0\nM2\n")
    with pytest.raises(diesink.Error) as caught:
        diesink.read_path(tmp_path / "arc.ngc")
    assert caught.value.diagnostics[0].line == 2
