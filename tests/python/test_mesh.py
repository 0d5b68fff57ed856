"""Tessellation, export and meshes as arrays."""
# SPDX-License-Identifier: Apache-2.0
import json
import os
import subprocess

import numpy as np
import pytest

import diesink
from conftest import PARTS


def test_a_ball_is_within_its_tolerance(ball):
    mesh = ball.tessellate(tolerance=0.01)
    assert mesh.kept and mesh.report["certified_deviation"] <= 0.01
    assert sorted(mesh.names) == ["B", "S1.surface"]
    on_ball = np.unique(mesh.triangles[mesh.element == mesh.names.index("S1.surface")])
    distance = np.linalg.norm(mesh.vertices[on_ball] - [5, 5, 0], axis=1)
    assert distance.min() >= 3 - 1e-9 and distance.max() <= 3.01  # inside, vertices stand off within the tolerance
    rim = np.abs(mesh.vertices[on_ball][:, 2]) < 1e-12
    assert rim.sum() > 20
    np.testing.assert_allclose(distance[rim], 3, atol=1e-9)
    assert mesh.report["triangles"] == len(mesh.triangles) == len(mesh.element)
    assert mesh.unit == "mm" and mesh.name == "ball"


def test_area_follows_from_the_arrays(fig6):
    mesh = fig6.tessellate()
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(mesh.report["area"], rel=1e-9)
    assert mesh.triangles.dtype == np.uint32 and mesh.triangles.max() < len(mesh.vertices)
    normals = mesh.normals[mesh.corner_normals]
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1, atol=1e-9)
    crease = next(c for c in mesh.curves if c.kind == "crease")
    assert len(crease.between) == 2 and crease.vertices.max() < len(mesh.vertices)


def test_arrays_outlive_their_mesh_and_do_not_change(ball):
    vertices = ball.tessellate().vertices
    curve = ball.tessellate().curves[0].vertices
    assert np.isfinite(vertices).all() and curve.size > 0
    with pytest.raises(ValueError):
        vertices[0, 0] = 1


def test_solid_is_closed(ball):
    mesh = ball.tessellate(solid=True, floor=-2)
    assert mesh.report["watertight"] and mesh.vertices[:, 2].min() == -2
    assert {"floor", "skirt"} <= set(mesh.names)


def test_export_writes_what_the_program_writes(tmp_path):
    part = diesink.load(PARTS / "fig6.part")
    report = part.export(tmp_path / "a.stl", str(tmp_path / "a.glb"), lines=True)
    done = subprocess.run([os.environ["DIESINK_PROGRAM"], "export", PARTS / "fig6.part", "--lines", "--json",
                           "-o", tmp_path / "b.stl", tmp_path / "b.glb"], check=True, capture_output=True)
    for ending in ("stl", "glb"):
        assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()
    theirs = json.loads(done.stdout)
    for key in theirs.keys() - {"seconds"}:
        assert report[key] == theirs[key], key
    assert report["kept"] and any("no lines" in note for _, note in report["notes"])


def test_export_refuses_what_the_program_refuses(ball, tmp_path):
    for wrong in ({"tolerance": -1}, {"tolerance": float("nan")}, {"draco": True}, {"mesh": "fine"}, {"tiles": (0, 1)},
                  {"creases": False}, {"split": "all"}, {"quantize": 31, "draco": True}):
        with pytest.raises(diesink.Error) as caught:
            ball.export(tmp_path / "x.stl", **wrong)
        assert caught.value.code == "usage"
    with pytest.raises(diesink.Error, match="ending"):
        ball.export(tmp_path / "x.step")
    with pytest.raises(diesink.Error) as caught:
        ball.export(tmp_path / "no/x.stl")
    assert caught.value.code == "output"
    assert not list(tmp_path.iterdir())


def test_mesh_of_arrays_and_back(tmp_path):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]])
    mesh = diesink.Mesh(vertices, [[0, 1, 2], [0, 2, 3]], [0, 1], ["S1.top", "S1.side"], unit="inch", name="sheet")
    mesh.write(tmp_path / "sheet.ply")
    again, warnings = diesink.read_mesh(tmp_path / "sheet.ply")
    assert not warnings
    np.testing.assert_array_equal(again.vertices, vertices)
    np.testing.assert_array_equal(again.triangles, mesh.triangles)
    np.testing.assert_array_equal(again.element, [0, 1])
    assert again.names == ["S1.top", "S1.side"] and again.unit == "inch" and again.report is None


@pytest.mark.parametrize("wrong, message", [
    ({"triangles": [[0, 1, 3]]}, "row 0 is outside"), ({"triangles": [[0, 1, -1]]}, "outside"),
    ({"triangles": [[0, 1]]}, "shape"), ({"vertices": [[0, 0, np.nan]] * 3}, "not finite"),
    ({"element": [0]}, "outside"), ({"element": [0, 0], "names": ["a"]}, "one number a triangle"), ({"unit": "ft"}, "none of")])
def test_wrong_arrays_are_refused(wrong, message):
    right = {"vertices": np.eye(3), "triangles": [[0, 1, 2]]}
    with pytest.raises(diesink.Error, match=message):
        diesink.Mesh(**{**right, **wrong})


def test_a_mesh_file_that_is_cut_off(ball, tmp_path):
    ball.tessellate().write(tmp_path / "whole.glb")
    (tmp_path / "cut.glb").write_bytes((tmp_path / "whole.glb").read_bytes()[:-100])
    with pytest.raises(diesink.Error) as caught:
        diesink.read_mesh(tmp_path / "cut.glb")
    assert caught.value.diagnostics[0].file.endswith("cut.glb")
