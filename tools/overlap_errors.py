#!/usr/bin/env python3
"""Measures the errors of `fieldstone overlap` on data/overlap-cases, by the ratio of sizes: the table in the README.

    cargo build --release && python tools/overlap_errors.py [FIELDSTONE] [METHOD]

FIELDSTONE is target/release/fieldstone and METHOD is kernel unless given. Errors are shares of the smaller of the two
volumes; sizes are the ball's radius over the largest extent of the element along an axis. Needs numpy.
"""

import csv
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent

#: Corners and faces in CGNS order.
ELEMENTS = {
    "tet": (4, [(2, 1, 0), (0, 1, 3), (1, 2, 3), (2, 0, 3)]),
    "wedge": (6, [(2, 1, 0), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5), (3, 4, 5)]),
    "hex": (8, [(3, 2, 1, 0), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]),
}

RANGES = [(0.0, 1e-3), (1e-3, 0.1), (0.1, 10.0), (10.0, 100.0), (100.0, 1000.0), (1000.0, math.inf)]


def volume(corners, faces):
    """Volume of an element with planar faces."""
    sides = corners - corners[0]
    six = sum(
        np.dot(sides[face[0]], np.cross(sides[face[k]], sides[face[k + 1]]))
        for face in faces
        for k in range(1, len(face) - 1)
    )
    return six / 6.0


def measure(program, method, folder):
    """(family, ratio of sizes, error) of every case."""
    for element, (count, faces) in ELEMENTS.items():
        cases, out = ROOT / f"data/overlap-cases/{element}.csv.gz", Path(folder) / f"{element}.csv"
        command = [program, "overlap", "--element", element, "--order", "cgns", "--method", method]
        subprocess.run([*command, "--cases", cases, "--out", out], check=True, capture_output=True)
        with open(out, newline="") as rows:
            for row in csv.DictReader(rows):
                corners = np.array([[float(row[f"{axis}{k}"]) for axis in "xyz"] for k in range(count)])
                radius = float(row["r"])
                smaller = min(4.0 / 3.0 * math.pi * radius**3, volume(corners, faces))
                error = abs(float(row["volume"]) - float(row["vol_exact"])) / smaller
                yield row["family"], radius / np.ptp(corners, axis=0).max(), error


def line(name, errors):
    errors = np.sort(errors)
    quantiles = " | ".join(f"{errors[int(share * (len(errors) - 1))]:.1e}" for share in (0.5, 0.95, 1.0))
    print(f"| {name} | {len(errors)} | {quantiles} | {(errors <= 1e-15).mean():.0%} |")


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/fieldstone"
    method = sys.argv[2] if len(sys.argv) > 2 else "kernel"
    with tempfile.TemporaryDirectory() as folder:
        cases = list(measure(program, method, folder))
    if len(cases) != 1200:
        sys.exit(f"{len(cases)} cases were measured; there are 1200")
    print("| radius / largest extent | cases | median | 95 % are below | largest | up to 1e-15 |")
    print("|---|---:|---:|---:|---:|---:|")
    for low, high in RANGES:
        line(f"{low:g} to {high:g}", [e for family, ratio, e in cases if family != "sliver" and low <= ratio < high])
    line("slivers", [e for family, _, e in cases if family == "sliver"])


if __name__ == "__main__":
    main()
