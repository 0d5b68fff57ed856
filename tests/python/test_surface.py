"""Part programs from Python: loading, evaluating, what is wrong with them."""
# SPDX-License-Identifier: Apache-2.0
import csv
import os
import pickle
import subprocess
import threading
import time

import numpy as np
import pytest

import diesink
from conftest import BALL, PARTS


def test_part_says_what_it_is(fig6, ball):
    assert fig6.name == "fig6"
    assert ball.unit == "mm"
    assert ball.domain == (0, 10, 0, 10)
    assert ball.solids == [("S1", "SPHER")]
    assert ball.boole == [("B", 1), ("S1", 1)]
    assert diesink.parse("UNITS,INCH\n" + BALL).unit == "inch"


def test_a_ball_has_the_heights_and_normals_of_a_ball(ball):
    x = np.linspace(0, 10, 201)
    data = ball.evaluate(x, 5.0)
    inside = np.abs(x - 5) < 3
    want = np.sqrt(np.maximum(0, 9 - (x - 5) ** 2))
    np.testing.assert_allclose(data.z, want, atol=1e-12)
    np.testing.assert_allclose(data.normals[inside, 0], (x[inside] - 5) / 3, atol=1e-12)
    assert data.names == ["B", "S1.surface"]
    assert [data.names[e] for e in data.element[[0, 100]]] == ["B", "S1.surface"]
    np.testing.assert_array_equal(data.surface, inside.astype(int))
    np.testing.assert_array_equal(data.row, inside.astype(int))
    assert data.z.dtype == np.float64 and data.element.dtype == np.int32


def test_shapes_broadcast(ball):
    data = ball.evaluate(np.zeros((4, 1)), [[1, 2, 3]])
    assert data.x.shape == data.z.shape == data.element.shape == (4, 3)
    assert data.normals.shape == (4, 3, 3)
    assert ball.evaluate(5, 5).z == 3
    assert ball.evaluate([], []).z.shape == (0,)
    with pytest.raises(ValueError):
        ball.evaluate([1, 2], [1, 2, 3])
    every_second = np.arange(20.0)[::2]
    np.testing.assert_array_equal(ball.evaluate(every_second, 5).x, every_second)


def test_where_there_is_no_surface():
    part = diesink.parse(BALL.replace("PLANE,0", "NONE").replace("B+S1", "S1"))
    data = part.evaluate([5, 0, np.nan, np.inf], 5)
    assert data.z[0] == 3
    assert np.isnan(data.z[1:]).all()
    assert (data.normals[1:] == 0).all()
    for numbers in (data.surface, data.row, data.face, data.element):
        assert (numbers[1:] == -1).all()


def test_grid_is_the_program_s(fig6, tmp_path):
    data = fig6.grid()
    subprocess.run([os.environ["DIESINK_PROGRAM"], "cc", PARTS / "fig6.part", "-o", tmp_path / "cc.csv", "--quiet"], check=True)
    with open(tmp_path / "cc.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert data.z.shape == (len(data.y), len(data.x)) and data.z.size == len(rows)
    for column, values in (("z", data.z), ("nx", data.normals[..., 0]), ("row", data.row), ("face", data.face)):
        np.testing.assert_array_equal(values.ravel(), [float(row[column]) for row in rows])


def test_grid_and_points_agree(fig6):
    x, y = np.linspace(1, 39, 37), np.linspace(1, 45, 23)
    grid = fig6.grid(x, y)
    points = fig6.evaluate(*np.meshgrid(x, y))
    for each in ("z", "surface", "row", "face"):
        np.testing.assert_array_equal(getattr(grid, each), getattr(points, each))
    one = fig6.grid(x, y, threads=1)
    np.testing.assert_array_equal(grid.z, one.z)
    np.testing.assert_array_equal(grid.z, fig6.grid(x, y, threads=10**9).z)
    for ask in (fig6.grid, fig6.evaluate):
        with pytest.raises(diesink.Error, match="numbers"):
            ask(["a"], ["b"])
    with pytest.raises(diesink.Error, match="ascend"):
        fig6.grid([2, 1], [1])


def test_errors_carry_their_diagnostics():
    with pytest.raises(diesink.Error) as caught:
        diesink.parse(BALL.replace("RAD,3", "RAD,-3").replace("X-RNG", "X-RGN"), "bad.part")
    error = caught.value
    assert isinstance(error, ValueError) and error.code == "input"
    first, second = error.diagnostics
    assert (first.file, first.line, first.column, first.severity) == ("bad.part", 4, 5, "error")
    assert "RAD" in first.message and first.source_line == "RAD,-3"
    assert "X-RNG" in second.message
    assert str(error).startswith("bad.part:4:5: error: ")
    assert "bad.part:10:1" in str(error)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(diesink.Error, match="nothing.part"):
        diesink.load(tmp_path / "nothing.part")


def test_warnings_are_kept_and_nothing_is_printed(capfd):
    part = diesink.parse(BALL.replace("BSURF-DEF", "S2,SPHER,1\nP1,1,1,0\nRAD,1\nBSURF-DEF"))
    assert len(part.warnings) == 1 and part.warnings[0].severity == "warning"
    assert "S2" in part.warnings[0].message
    assert capfd.readouterr() == ("", "")


def test_a_scan_is_found_beside_the_program(tmp_path):
    mesh = diesink.Mesh([[0, 0, 1], [9, 0, 1], [9, 9, 1], [0, 9, 1]], [[0, 1, 2], [0, 2, 3]])
    mesh.write(tmp_path / "scan.stl")
    text = "BSURF-DEF\nMESH,scan.stl\nBOOLE-DEF\nB\n"
    assert diesink.parse(text, str(tmp_path / "x.part")).evaluate(4, 3).z == 1
    with pytest.raises(diesink.Error, match="scan.stl"):
        diesink.parse(text, str(tmp_path / "elsewhere/x.part"))


def test_another_thread_runs_meanwhile(fig6):
    # A counter that goes on while one call works: the interpreter's lock is free.
    counted = [0]
    done = threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.0005)

    counter = threading.Thread(target=count)
    counter.start()
    before = counted[0]
    fig6.tessellate(tolerance=0.0005)
    during = counted[0] - before
    done.set()
    counter.join()
    assert during > 3


def test_parts_do_not_pickle_by_accident(ball):
    with pytest.raises(TypeError):
        pickle.dumps(ball)
