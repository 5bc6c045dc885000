#!/usr/bin/env python3
"""Writes the derivatives that the overlap kernel is tested against, by finite differences in many digits.

    python tools/gradient_cases.py [--check DIR] [-o FILE]

Needs `mpmath` (with `gmpy2` it is several times faster); takes some minutes. FILE is
data/gradient-cases/cases.csv unless given.

The volume is computed by a route that has nothing in common with the kernel's sums over edges: the body is cut
into slices along a direction in general position, the area of each slice (polygon and disc, in the plane) is
exact, and the slices are integrated by tanh-sinh quadrature between all the heights at which the area is not
smooth: corners, points where an edge pierces the sphere, ends of the circles in which faces meet the sphere,
ends of the sphere. The derivative with respect to each coordinate of the centre and to the radius is a central
difference with a step of 1e-11 (1e-14 where the second derivative jumps).

`--check` compares the volumes with those of a folder of reference cases (data/overlap-cases) and writes nothing.

Columns: name, kind, cx cy cz r, x0 y0 z0 … (CGNS order), volume, gradient_x gradient_y gradient_z,
sphere_area; corners that a kind does not have are left empty.
"""

import argparse
import csv
import gzip
import multiprocessing
import random
import sys
from fractions import Fraction
from pathlib import Path

from mpmath import mp, mpf

mp.dps = 38
ROOT = Path(__file__).resolve().parent.parent

FACES = {
    "tet": [[2, 1, 0], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    "pyramid": [[3, 2, 1, 0], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
    "wedge": [[2, 1, 0], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5], [3, 4, 5]],
    "hex": [[3, 2, 1, 0], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]],
}
UNIT = {
    "tet": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "pyramid": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)],
    "wedge": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
    "hex": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
}


def rotation():
    """A rotation into general position: no face of a test shape is parallel to a slice."""
    def about(axis, angle):
        c, s = mp.cos(angle), mp.sin(angle)
        m = [[mpf(i == j) for j in range(3)] for i in range(3)]
        j, k = (axis + 1) % 3, (axis + 2) % 3
        m[j][j], m[j][k], m[k][j], m[k][k] = c, -s, s, c
        return mp.matrix(m)
    return about(0, mpf("0.61")) * about(1, mpf("0.37")) * about(2, mpf("1.13"))


TURN = [[rotation()[i, j] for j in range(3)] for i in range(3)]


def turned(p):
    return tuple(row[0] * p[0] + row[1] * p[1] + row[2] * p[2] for row in TURN)


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def disc_sector(px, py, qx, qy, s2):
    """Signed area of the disc of squared radius s2 inside the triangle (centre, p, q)."""
    dx, dy = qx - px, qy - py
    a = dx * dx + dy * dy
    if a == 0:
        return mpf(0)
    turn = px * qy - py * qx
    b = px * dx + py * dy
    root2 = s2 * a - turn * turn
    if root2 <= 0:
        return s2 * mp.atan2(turn, px * qx + py * qy) / 2
    root = mp.sqrt(root2)
    low, high = max(mpf(0), (-b - root) / a), min(mpf(1), (-b + root) / a)
    if low >= high:
        return s2 * mp.atan2(turn, px * qx + py * qy) / 2
    area = turn * (high - low)
    if low > 0:
        x, y = px + low * dx, py + low * dy
        area += s2 * mp.atan2(px * y - py * x, px * x + py * y)
    if high < 1:
        x, y = px + high * dx, py + high * dy
        area += s2 * mp.atan2(x * qy - y * qx, x * qx + y * qy)
    return area / 2


def volume(corners, faces, centre, r):
    """Volume of ball ∩ polyhedron."""
    points = [turned(sub(p, centre)) for p in corners]
    r2 = r * r
    heights = {-r, r}
    edges = set()
    for face in faces:
        for a, b in zip(face, face[1:] + face[:1]):
            edges.add((min(a, b), max(a, b)))
        n = cross(sub(points[face[1]], points[face[0]]), sub(points[face[2]], points[face[0]]))
        nn = dot(n, n)
        d = dot(n, points[face[0]])
        s2 = r2 - d * d / nn
        if s2 > 0:
            # The circle in the face's plane: its middle, and how far it rises above it.
            middle, rise = d * n[2] / nn, mp.sqrt(s2 * (1 - n[2] * n[2] / nn))
            heights |= {middle - rise, middle + rise}
    for a, b in edges:
        p, along = points[a], sub(points[b], points[a])
        aa, pa = dot(along, along), dot(p, along)
        root2 = pa * pa - aa * (dot(p, p) - r2)
        if root2 >= 0:
            for sign in (-1, 1):
                t = (-pa + sign * mp.sqrt(root2)) / aa
                if 0 <= t <= 1:
                    heights.add(p[2] + t * along[2])
    heights |= {p[2] for p in points}
    low = max(-r, min(p[2] for p in points))
    high = min(r, max(p[2] for p in points))
    if low >= high:
        return mpf(0)
    inside = sorted(h for h in heights if low <= h <= high)
    cuts = [inside[0]]
    for h in inside[1:]:
        if h - cuts[-1] > mpf(10) ** (6 - mp.dps):
            cuts.append(h)

    def area(z):
        s2 = r2 - z * z
        if s2 <= 0:
            return mpf(0)
        total = mpf(0)
        for face in faces:
            enter = leave = None
            previous = points[face[-1]]
            for k in face:
                p = points[k]
                if (p[2] >= z) != (previous[2] >= z):
                    t = (z - previous[2]) / (p[2] - previous[2])
                    at = (previous[0] + t * (p[0] - previous[0]), previous[1] + t * (p[1] - previous[1]))
                    # Seen with the inside on the left, a slice of a face runs from where its outline goes down
                    # to where it goes up.
                    if p[2] >= z:
                        leave = at
                    else:
                        enter = at
                previous = p
            if enter is not None:
                total += disc_sector(*enter, *leave, s2)
        return total

    return mp.fsum(mp.quad(area, [a, b]) for a, b in zip(cuts, cuts[1:]))


def case(kind, name, corners, centre, r, step):
    """One row."""
    faces = FACES[kind]
    corners = [tuple(mpf(x.numerator) / x.denominator for x in p) for p in corners]
    at = [mpf(x.numerator) / x.denominator for x in centre]
    radius = mpf(r.numerator) / r.denominator
    h = mpf(step)
    gradient = []
    for axis in range(3):
        ahead, behind = list(at), list(at)
        ahead[axis] += h
        behind[axis] -= h
        gradient.append((volume(corners, faces, ahead, radius) - volume(corners, faces, behind, radius)) / (2 * h))
    area = (volume(corners, faces, at, radius + h) - volume(corners, faces, at, radius - h)) / (2 * h)
    row = [name, kind, *(mp.nstr(x, 17) for x in (*at, radius))]
    row += [mp.nstr(x, 17) for p in corners for x in p] + [""] * (3 * (8 - len(corners)))
    # A difference is no better than its step: what is left of an exact 0 is noise below that.
    return row + [mp.nstr(x, 17) for x in (volume(corners, faces, at, radius), *gradient, area)]


def tapered(kind, scale, shift):
    """The unit shape with its top scaled and shifted: opposite faces are no longer parallel, all stay planar."""
    corners = [tuple(Fraction(x) for x in p) for p in UNIT[kind]]
    return [(x * (1 + (scale - 1) * z) + shift[0] * z, y * (1 + (scale - 1) * z) + shift[1] * z, z)
            for x, y, z in corners]


def jobs():
    rng = random.Random(20160815)
    f = Fraction
    for kind in FACES:
        unit = [tuple(f(x) for x in p) for p in UNIT[kind]]
        # All unit shapes have the corner at the origin with edges along the axes.
        special = [
            ("centre_on_vertex", (0, 0, 0), f(1, 2)),
            ("centre_on_vertex_radius_to_the_next", (0, 0, 0), f(1)),
            ("centre_on_edge", (0, 0, f(3, 8)), f(1, 4)),
            ("centre_on_face", (f(1, 4), 0, f(1, 4)), f(3, 16)),
            ("tangent_to_face_inside", (f(1, 4), f(1, 8), f(3, 8)), f(1, 4)),
            ("tangent_to_face_outside", (f(-1, 4), f(1, 8), f(1, 8)), f(1, 4)),
            ("tangent_to_edge_inside", (f(3, 16), f(4, 16), f(1, 4)), f(5, 16)),
            ("tangent_to_edge_outside", (f(-3, 16), f(4, 16), f(1, 4)), f(3, 16)),
            ("through_vertex_inside", (f(2, 16), f(3, 16), f(6, 16)), f(7, 16)),
            ("through_vertex_one_face", (f(2, 8), f(-1, 8), f(2, 8)), f(3, 8)),
            ("through_vertex_two_faces", (f(-3, 16), f(-2, 16), f(6, 16)), f(7, 16)),
            ("through_vertex_from_afar", (f(-4, 16), f(-12, 16), f(3, 16)), f(13, 16)),
        ]
        for name, centre, r in special:
            yield kind, name, unit, tuple(f(x) for x in centre), r, "1e-14"
        count = 0
        while count < 10:
            corners = tapered(kind, f(rng.randint(16, 40), 32), (f(rng.randint(-8, 8), 32), f(rng.randint(-8, 8), 32)))
            m = [[f(rng.randint(-32, 32), 32) for _ in range(3)] for _ in range(3)]
            det = dot(m[0], cross(m[1], m[2]))
            if det < f(1, 8):
                continue
            corners = [tuple(dot(row, p) for row in m) for p in corners]
            weights = [rng.random() for _ in corners]
            middle = [sum(w * p[k] for w, p in zip(weights, corners)) / f(sum(weights)) for k in range(3)]
            centre = tuple(f(round(x * 512) + rng.randint(-100, 100), 512) for x in middle)
            r = f(rng.randint(120, 700), 512)
            distances = [dot(d, d) for d in (sub(p, centre) for p in corners)]
            if max(distances) < r * r:
                continue
            yield kind, f"generic_{count}", corners, centre, r, "1e-11"
            count += 1


def check(folder):
    worst = {}
    for kind in ("tet", "wedge", "hex"):
        with gzip.open(folder / f"{kind}.csv.gz", "rt") as file:
            rows = list(csv.DictReader(file))
        done = {}
        for row in rows:
            family = row["family"]
            if family.startswith(("huge", "sliver")) or done.get(family, 0) >= 4:
                continue
            done[family] = done.get(family, 0) + 1
            centre = [mpf(float(row[k])) for k in ("cx", "cy", "cz")]
            corners, k = [], 0
            while f"x{k}" in row:
                corners.append(tuple(mpf(float(row[f"{axis}{k}"])) for axis in "xyz"))
                k += 1
            r = mpf(float(row["r"]))
            found, true = volume(corners, FACES[kind], centre, r), mpf(row["vol_exact"])
            error = float(abs(found - true) / r**3)
            worst[kind, family] = max(worst.get((kind, family), 0.0), error)
            print(kind, family, f"{error:.1e}", flush=True)
    for (kind, family), error in sorted(worst.items()):
        print(f"{kind:8} {family:20} {error:.1e} r³")


def star(job):
    return case(*job)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", type=Path, metavar="DIR")
    parser.add_argument("-o", type=Path, default=ROOT / "data/gradient-cases/cases.csv", metavar="FILE")
    options = parser.parse_args()
    if options.check:
        check(options.check)
        return
    header = ["name", "kind", "cx", "cy", "cz", "r"] + [f"{a}{k}" for k in range(8) for a in "xyz"]
    header += ["volume", "gradient_x", "gradient_y", "gradient_z", "sphere_area"]
    todo = list(jobs())
    options.o.parent.mkdir(parents=True, exist_ok=True)
    with multiprocessing.Pool() as pool, open(options.o, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for k, row in enumerate(pool.imap(star, todo)):
            writer.writerow(row)
            file.flush()
            print(f"{k + 1}/{len(todo)} {row[1]} {row[0]}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
