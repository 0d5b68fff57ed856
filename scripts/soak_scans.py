#!/usr/bin/env python3
"""Exports random dies over the scans of make_scans.py and checks the meshes by an evaluation of its own; keeps what fails.

  soak_scans.py KIND|all FIRST COUNT [--build build/release] [--folder build/soak] [--slow SECONDS]

Each die is exported (some as a solid, some in tiles) with a limit of 60 s and looked at (numpy, as python3-numpy has it):
- no edge has more than two triangles, those look the same way, and a solid has no border; the border of a sheet is that of
  the surface;
- over each random point of the plan is one triangle that looks up where there is a surface, and none where there is none;
- points of the mesh lie within the tolerance of the surface, and those of the surface under or over one of the mesh that does.
Where the program tells an area (status 5) no more than that area may differ. Ends with 1 where something fails, crashes or
does not end."""
# SPDX-License-Identifier: Apache-2.0
import json
import math
import pathlib
import sys
import tempfile

import numpy as np

import make_scans
from soak import Look, options_of, run, soak

POINTS = 3000  # of the plan, and of the mesh


class Triangles:
    """Triangles by cells of the plan: what a vertical line meets."""

    def __init__(self, corners):
        self.corners = corners
        plan = corners[:, :, :2]
        self.low = plan.min((0, 1))
        self.n = max(1, int(math.sqrt(len(corners) / 2)))
        self.step = np.maximum(plan.max((0, 1)) - self.low, 1e-12) / self.n
        first, last = (np.clip(((pick(1) - self.low) / self.step + off).astype(int), 0, self.n - 1)
                       for pick, off in ((plan.min, -1e-6), (plan.max, 1e-6)))
        wide = last - first + 1
        count = wide.prod(1)
        triangle = np.repeat(np.arange(len(corners)), count)
        k = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        cell = (first[triangle, 1] + k // wide[triangle, 0]) * self.n + first[triangle, 0] + k % wide[triangle, 0]
        order = np.argsort(cell, kind="stable")
        self.triangle = triangle[order]
        self.start = np.searchsorted(cell[order], np.arange(self.n * self.n + 1))

    def hits(self, p):
        """(point, triangle, height, least weight) of each triangle over each point, borders included."""
        at = (p - self.low) / self.step
        cell = np.clip(at.astype(int), 0, self.n - 1) @ [1, self.n]
        count = np.where(((at < -1e-6) | (at > self.n + 1e-6)).any(1), 0, self.start[cell + 1] - self.start[cell])
        point = np.repeat(np.arange(len(p)), count)
        triangle = self.triangle[self.start[cell][point] + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)]
        q = self.corners[triangle] - np.concatenate([p[point], np.zeros((len(point), 1))], 1)[:, None]
        x, y, z = q[..., 0], q[..., 1], q[..., 2]
        w = np.stack([x[:, 1] * y[:, 2] - x[:, 2] * y[:, 1], x[:, 2] * y[:, 0] - x[:, 0] * y[:, 2],
                      x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]], 1)
        area = w.sum(1)
        size = np.abs(q[..., :2]).max((1, 2))
        with np.errstate(all="ignore"):
            w = w / area[:, None]
            inside = (w >= -1e-12).all(1) & (np.abs(area) > 1e-15 * size * size)
            height = np.clip((w * z).sum(1), z.min(1), z.max(1))
        return point[inside], triangle[inside], height[inside], w[inside].min(1)

    def top(self, p):
        point, _, height, _ = self.hits(p)
        z = np.full(len(p), -np.inf)
        np.maximum.at(z, point, height)
        return np.where(z == -np.inf, np.nan, z)


def interval(body, p):
    """The lower and upper end of a convex body on vertical lines, nan beside it."""
    _, shape, *data = body
    x, y = p.T
    nowhere = np.full(len(p), np.nan)
    if shape == "BLOCK":
        one, two = np.minimum(*data), np.maximum(*data)
        inside = (p >= one[:2]).all(1) & (p <= two[:2]).all(1)
        return np.where(inside, one[2], np.nan), np.where(inside, two[2], np.nan)
    centre = np.array(data[0])
    if shape == "SPHER":
        with np.errstate(invalid="ignore"):
            half = np.sqrt(data[1] ** 2 - (x - centre[0]) ** 2 - (y - centre[1]) ** 2)
        return centre[2] - half, centre[2] + half
    axis = np.array(data[1]) - centre
    length = math.sqrt(axis @ axis)
    axis /= length
    slope = -data[2] / length if shape == "R-CONE" else 0.0
    # Of the point at z = 0 and its change with z: along the axis, and the square of what lies across it.
    q = np.stack([x, y, np.zeros(len(p))], 1) - centre
    s, ds = q @ axis, axis[2]
    radius, dr = data[2] + slope * s, slope * ds
    a = 1 - ds * ds - dr * dr
    b = (q[:, 2] - s * ds) - radius * dr
    c = (q * q).sum(1) - s * s - radius * radius
    ends = []
    with np.errstate(all="ignore"):
        root = np.sqrt(b * b - a * c)
        far = -(b + np.copysign(root, b))
        ends += [far / a, c / far] if abs(a) > 1e-12 else [-c / (2 * b)]
        if abs(ds) > 1e-12:
            ends += [-s / ds, (length - s) / ds]
        ends = np.sort(np.stack(ends), 0)  # nan come last
        low, high = nowhere.copy(), nowhere.copy()
        for one, two in zip(ends, ends[1:]):
            m = (one + two) / 2
            along = s + m * ds
            inside = (two > one) & (a * m * m + 2 * b * m + c <= 0) & (along >= 0) & (along <= length)
            low = np.where(inside & np.isnan(low), one, low)
            high = np.where(inside, two, high)
    return low, high


class Surface:
    def __init__(self, kind, seed):
        vertices, triangles, statements, self.bodies, domain, self.tolerance, self.fill = make_scans.make(kind, seed)
        points = np.array(make_scans.placed(vertices, statements))
        corners = points[np.array(triangles)]
        self.scan = Triangles(corners)
        low, high = corners.min((0, 1)), corners.max((0, 1))
        self.domain = domain or (low[0], high[0], low[1], high[1])
        self.size = max(self.domain[1] - self.domain[0], self.domain[3] - self.domain[2])

    def heights(self, p, everywhere=False):
        z = self.scan.top(p)
        for body in self.bodies:
            low, high = interval(body, p)
            z = np.fmax(z, high) if body[0] == "+" else np.minimum(z, np.where(np.isnan(low), np.inf, low))
        x0, x1, y0, y1 = self.domain
        if everywhere:
            return z
        return np.where((p[:, 0] < x0) | (p[:, 0] > x1) | (p[:, 1] < y0) | (p[:, 1] > y1), np.nan, z)

    def near(self, p, reach, rings=(0.1, 0.5, 0.85, 0.995), around=16):
        """Whether balls of that radius about points (nan: any height) meet the surface with its walls; whether a border is in reach."""
        offset = [(0, 0)] + [(reach * f * math.cos(a), reach * f * math.sin(a)) for f in rings
                             for a in np.linspace(0, 2 * math.pi, around, endpoint=False) + f]
        above, below, defined = (np.zeros(len(p), bool) for _ in range(3))
        border = np.zeros(len(p), bool)
        for dx, dy in offset:
            half = math.sqrt(max(0, reach * reach - dx * dx - dy * dy))
            q = p[:, :2] + [dx, dy]
            z = self.heights(q)
            defined |= ~np.isnan(z)
            border |= np.isnan(z)
            # (On the domain's sides and a hair beyond: walls may run along them.)
            for z in (self.heights(q, True), self.heights(np.clip(q, *np.array(self.domain).reshape(2, 2).T))):
                with np.errstate(invalid="ignore"):
                    above |= z >= p[:, 2] - half
                    below |= z <= p[:, 2] + half
        return above & below, border & defined


def read_mesh(path):
    """(vertices, faces) of a binary PLY of triangles as the program writes it."""
    head, data = path.read_bytes().split(b"end_header\n", 1)
    kinds = {"double": "<f8", "float": "<f4", "int": "<i4", "uint": "<u4", "uchar": "u1"}
    at, out, fields, count = 0, {}, None, 0
    elements = []
    for line in head.decode("latin1").splitlines():
        words = line.split()
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:2] == ["property", "list"]:
            elements[-1][2].extend([("count", "u1"), ("corners", kinds[words[3]], 3)])
        elif words[:1] == ["property"]:
            elements[-1][2].append((words[2], kinds[words[1]]))
    for name, count, fields in elements:
        if name in ("vertex", "face"):
            out[name] = np.frombuffer(data, np.dtype(fields), count, at)
            at += out[name].nbytes
    v = out["vertex"]
    return np.stack([v["x"], v["y"], v["z"]], 1), out["face"]["corners"].astype(np.int64)


def edges_of(faces):
    """(edges with their lower vertex first, triangles of each, the sum of their directions)."""
    e = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    way = np.where(e[:, 0] < e[:, 1], 1, -1)
    e, inverse, count = np.unique(np.sort(e, 1), axis=0, return_inverse=True, return_counts=True)
    turned = np.zeros(len(e), int)
    np.add.at(turned, inverse.ravel(), way)
    return e, count, turned


def welded(vertices, faces):
    _, first, inverse = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    return vertices[first], inverse.ravel()[faces]


def check(surface, meshes, solid, watertight, told, certified, rng):
    """What is wrong with meshes of a die (one a tile): lines."""
    lines = []
    reach = max(surface.tolerance, certified) * 1.001 + 1e-9 * surface.size
    x0, x1, y0, y1 = surface.domain
    area = (x1 - x0) * (y1 - y0)

    def too_many(bad, of):
        expected = of * 1.5 * told / area
        return bad > expected + 4 * math.sqrt(expected) + 0.5 * (told > 0)
    for vertices, faces in meshes:
        _, count, turned = edges_of(faces)
        if (count > 2).any() or ((count == 2) & (turned != 0)).any() or (watertight and (count == 1).any()):
            lines.append(f"topology: {(count > 2).sum()} edges of more than two, {((count == 2) & (turned != 0)).sum()} turned, "
                         f"{(count == 1).sum()} open")
    vertices = np.concatenate([v for v, _ in meshes])
    before = np.cumsum([0] + [len(v) for v, _ in meshes])
    vertices, faces = welded(vertices, np.concatenate([f + k for (_, f), k in zip(meshes, before)]))
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    size = np.linalg.norm(normal, axis=1)
    if not solid:
        down = normal[:, 2] < -1e-7 * size - 1e-14 * area
        if -normal[down, 2].sum() > 2 * told or (down.any() and told == 0):
            lines.append(f"{down.sum()} triangles look down, {-normal[down, 2].sum():.3g} of the plan; the first at "
                         f"{corners[down][0].mean(0).tolist()}")
        edges, count, _ = edges_of(faces)
        a, b = vertices[edges[count % 2 == 1, 0]], vertices[edges[count % 2 == 1, 1]]
        middle, along = (a + b) / 2, b - a
        across = np.stack([-along[:, 1], along[:, 0]], 1)
        length = np.linalg.norm(across, axis=1)
        inside = np.ones(len(middle), bool)
        for far in (0, 1e-9 * surface.size, 1e-7 * surface.size, 1e-6 * surface.size, 0.1 * reach, reach, 2 * reach):
            for side in (-1, 1):
                with np.errstate(all="ignore"):
                    inside &= ~np.isnan(surface.heights(middle[:, :2] + side * far * across / length[:, None]))
        inside &= length > 0
        if inside.sum() and (told == 0 or (length[inside] * reach).sum() > 2 * told):
            lines.append(f"{inside.sum()} edges of the border lie within the surface, the first at {middle[inside][0].tolist()}")

    plan = np.stack([rng.uniform(x0, x1, POINTS), rng.uniform(y0, y1, POINTS)], 1)
    true = surface.heights(plan)
    if surface.fill:
        bare = np.isnan(surface.scan.top(plan))
        plan, true = plan[~bare], true[~bare]  # what patches look like is the program's affair
    mesh = Triangles(corners)
    point, triangle, height, weight = mesh.hits(plan)
    unsure = np.zeros(len(plan), bool)
    unsure[point[weight < 1e-9]] = True
    ups = np.bincount(point[normal[triangle, 2] > 0], minlength=len(plan))
    seen = mesh.top(plan)
    wrong = ~unsure & (ups != (~np.isnan(true)))
    if wrong.any():
        _, border = surface.near(np.c_[plan[wrong], true[wrong]], reach)
        once = border & (ups[wrong] <= 1)
        wrong[np.flatnonzero(wrong)[once]] = False
    if too_many(wrong.sum(), len(plan)):
        k = np.flatnonzero(wrong)[0]
        lines.append(f"{wrong.sum()} of {len(plan)} points have other triangles than one, such as {ups[k]} at {plan[k].tolist()}")

    def far_off(p):
        doubtful = np.flatnonzero(~(np.abs(surface.heights(p[:, :2]) - p[:, 2]) <= reach))
        for rings, around in (((0.1, 0.5, 0.85, 0.995), 16), (np.geomspace(1e-4, 1, 24), 16), (np.linspace(0.02, 1, 50), 360)):
            near, border = surface.near(p[doubtful], reach, rings, around)
            doubtful = doubtful[~near & ~(border & solid)]
        return doubtful
    both = ~np.isnan(true) & ~np.isnan(seen)
    over = np.c_[plan, seen][both]
    bad = far_off(over)
    if too_many(len(bad), len(over)):
        p = over[bad[0]]
        lines.append(f"{len(bad)} of {len(over)} points off, such as {p.tolist()} of {surface.heights(p[None, :2])[0]}")
    if told == 0:
        if solid:
            keep = normal[:, 2] > 0
            corners, size = corners[keep], size[keep]
        k = rng.choice(len(corners), POINTS, p=size / size.sum())
        r = rng.random((POINTS, 2))
        s, t = np.sqrt(r[:, :1]), r[:, 1:]
        on = (1 - s) * corners[k, 0] + s * (1 - t) * corners[k, 1] + s * t * corners[k, 2]
        if surface.fill:
            on = on[~np.isnan(surface.scan.top(on[:, :2]))]
        bad = far_off(on)
        if len(bad):
            p = on[bad[0]]
            lines.append(f"{len(bad)} of {len(on)} points of the mesh off, such as {p.tolist()} of {surface.heights(p[None, :2])[0]}")
    return lines


def look_at(seed, options):
    kind = make_scans.kind_of(options.kind, seed)
    part = make_scans.write(kind, seed, options.folder)
    surface = Surface(kind, seed)
    rng = np.random.default_rng(seed)
    ways = [[]]
    if seed % 3 == 1:
        ways.append(["--solid"])
    if seed % 4 == 2:
        ways.append(["--tiles", "2x3"])
    failed, lines = False, []
    for way in ways:
        name = " ".join(["export", *way])
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            status, out, err, seconds = run(options.build / "bin/diesink", "export", part, "-o", folder / "die.ply", "--json",
                                            "--threads", 1, *way)
            if status == 2:
                lines.append(f"{name} refused: {err[:200]}")
                if "no triangle of the scan" not in err and "no surface" not in err:
                    failed = True
                continue
            if status not in (0, 5):
                failed = True
                lines.append(f"{name} ends with {status}: {err[:300]}")
                continue
            figures = json.loads(out)
            told = figures["uncertified_area"]
            if status == 5:
                lines.append(f"{name} tells {told:.3g} of {(surface.domain[1] - surface.domain[0]) * (surface.domain[3] - surface.domain[2]):.4g}, "
                             f"deviation {figures['certified_deviation']:.3g} at {surface.tolerance}")
            if seconds > options.slow:
                lines.append(f"{name} takes {seconds:.1f} s")
            meshes = [read_mesh(path) for path in sorted(folder.glob("die*.ply"))]
        wrong = check(surface, meshes, "--solid" in way, "--solid" in way and figures["watertight"], told, figures["certified_deviation"], rng)
        if "--solid" in way and status == 0 and not figures["watertight"]:
            wrong.append("certified, and not closed")
        failed = failed or bool(wrong)
        lines += [f"{name} WRONG: {line}" for line in wrong]
    return Look(part.stem, [part, part.with_suffix(".stl")], failed, lines)


if __name__ == "__main__":
    sys.exit(soak(look_at, "dies over scans", options_of(__doc__, [*make_scans.KINDS, "all"], slow=5)))
