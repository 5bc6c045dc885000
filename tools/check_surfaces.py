#!/usr/bin/env python3
"""Opens surfaces that `fieldstone surface` wrote with pyvista: closed, manifold, outward, and of the volume that it told.

    fieldstone surface --particles P --spacing DX --out S.ply --json S.json && python tools/check_surfaces.py S.ply S.json
    python tools/check_surfaces.py --with target/release/fieldstone FOLDER

Takes any number of pairs of a surface (.vtp, .ply, .obj, .stl) and its summary; or makes them itself, of a ball, a torus and
two drops that touch. Ends with status 1 at the first that differs, and where nothing was compared. Needs numpy, vtk and
pyvista.
"""

import json
import pathlib
import subprocess
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


def bodies():
    """Name, number of parts, and the particles of a unit lattice that are inside."""
    x, y, z = lattice = np.mgrid[-24:25, -24:25, -24:25].reshape(3, -1) + 0.5
    ball = lambda cx, r: (x - cx) ** 2 + y**2 + z**2 < r**2
    torus = (np.hypot(x, y) - 13) ** 2 + z**2 < 6**2
    drops = ball(-8.1, 8) | ball(8.1, 8)
    for name, inside in (("ball", ball(0, 12)), ("torus", torus), ("drops", drops)):
        yield name, lattice[:, inside].T


def make(binary, folder):
    """Surfaces of all bodies, from the level set and from the density, in all formats."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    pairs = []
    for name, positions in bodies():
        particles = folder / f"{name}.csv"
        np.savetxt(particles, positions, delimiter=",", header="x,y,z", comments="")
        for field in ("level-set", "density"):
            for suffix in ("vtp", "ply", "obj", "stl"):
                surface, summary = (folder / f"{name}-{field}.{kind}" for kind in (suffix, f"{suffix}.json"))
                command = [binary, "surface", "--particles", particles, "--spacing", "1", "--from", field]
                command += ["--out", surface, "--json", summary]
                subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
                pairs.append((surface, summary))
    return pairs


def main():
    if len(sys.argv) == 4 and sys.argv[1] == "--with":
        pairs = make(sys.argv[2], sys.argv[3])
    elif len(sys.argv) >= 3 and len(sys.argv) % 2 == 1:
        pairs = list(zip(sys.argv[1::2], sys.argv[2::2]))
    else:
        sys.exit(__doc__)
    for path, summary in pairs:
        with open(summary) as file:
            problems = check(path, json.load(file))
        if problems:
            sys.exit(f"{path}: {'; '.join(problems)}")
    print(f"pyvista {pyvista.__version__} finds {len(pairs)} surfaces closed, manifold and of the volume told")


if __name__ == "__main__":
    main()
