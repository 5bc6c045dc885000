#!/usr/bin/env python3
"""Opens surfaces that `fieldstone surface` wrote with pyvista: closed, manifold, outward, and of the volume that it told.

    fieldstone surface --particles P --spacing DX --out S.ply --json S.json && python tools/check_surfaces.py S.ply S.json

Takes any number of pairs of a surface (.vtp, .ply, .obj, .stl) and its summary. Ends with status 1 at the first that
differs, and where nothing was compared. Needs numpy, vtk and pyvista.
"""

import json
import sys

import numpy as np
import pyvista


def check(path, summary):
    surface = pyvista.read(path)
    problems = []
    if surface.n_open_edges != 0:
        problems.append(f"{surface.n_open_edges} open edges")
    if not surface.is_manifold:
        problems.append("not manifold")
    if surface.n_cells != summary["triangles"]:
        problems.append(f"{surface.n_cells} triangles instead of {summary['triangles']}")
    # 32-bit coordinates in STL, and pyvista's own sums.
    for name in ("volume", "area"):
        if not np.isclose(getattr(surface, name), summary[name], rtol=1e-5):
            problems.append(f"{name} {getattr(surface, name)} instead of {summary[name]}")
    parts = surface.connectivity().point_data["RegionId"].max() + 1
    if parts != summary["parts"]:
        problems.append(f"{parts} parts instead of {summary['parts']}")
    faces = surface.regular_faces
    a, b, c = (surface.points[faces[:, k]].astype(float) for k in range(3))
    signed = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    if signed <= 0:
        problems.append("wound inwards")
    return problems


def main():
    if len(sys.argv) < 3 or len(sys.argv) % 2 == 0:
        sys.exit(__doc__)
    pairs = list(zip(sys.argv[1::2], sys.argv[2::2]))
    for path, summary in pairs:
        with open(summary) as file:
            problems = check(path, json.load(file))
        if problems:
            sys.exit(f"{path}: {'; '.join(problems)}")
    print(f"pyvista {pyvista.__version__} finds {len(pairs)} surfaces closed, manifold and of the volume told")


if __name__ == "__main__":
    main()
