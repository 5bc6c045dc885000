#!/usr/bin/env python3
"""Opens files that fieldstone wrote with VTK, pyvista and meshio, and compares every number.

    cargo run -p fieldstone-io --example write_vtk_samples -- FOLDER
    python tools/check_vtk_output.py FOLDER [RESULT.vtu ...]

Each RESULT is what `fieldstone fields` wrote on a mesh: both readers must find the same in it, and the settings.

Ends with status 1 at the first difference, at any error or warning that VTK reports, and where nothing was
compared. Needs numpy, vtk, pyvista and meshio.
"""

import contextlib
import io
import json
import sys
from pathlib import Path

import meshio
import numpy as np
import pyvista
import vtk

#: What meshio cannot read by design: LZ4, mixed standard cells and polyhedra.
MESHIO_READS = ("standard_",)

SINCE_VTK97 = (vtk.vtkVersion.GetVTKMajorVersion(), vtk.vtkVersion.GetVTKMinorVersion()) >= (9, 7)


class Difference(Exception):
    pass


class Complaints:
    """Collects what VTK would only print."""

    def __init__(self):
        self.found = []
        window = vtk.vtkOutputWindow.GetInstance()
        window.SetDisplayModeToNever()
        for event in ("ErrorEvent", "WarningEvent"):
            window.AddObserver(event, self.note)
        self.note.__func__.CallDataType = "string0"

    def note(self, _, event, text=""):
        self.found.append(f"{event}: {text}")


Complaints.note.CallDataType = "string0"


def equal(found, wanted, what):
    found, wanted = np.asarray(found), np.asarray(wanted)
    if found.size != wanted.size:
        raise Difference(f"{what}: {found.size} numbers instead of {wanted.size}")
    if not np.array_equal(found.reshape(-1), wanted.reshape(-1)):
        raise Difference(f"{what}: {found.reshape(-1)[:5]}… instead of {wanted.reshape(-1)[:5]}…")


def columns(found, wanted, what):
    if set(found) != set(wanted):
        raise Difference(f"{what}: columns {sorted(found)} instead of {sorted(wanted)}")
    for name, column in wanted.items():
        values = np.asarray(found[name])
        if values.dtype != column["type"]:
            raise Difference(f"{what}, {name}: {values.dtype} instead of {column['type']}")
        rows = len(column["numbers"]) // column["components"]
        if values.shape not in ((rows, column["components"]), (rows,), (rows, 3, 3)):
            raise Difference(f"{what}, {name}: shape {values.shape}")
        equal(values, np.array(column["numbers"], dtype=column["type"]), f"{what}, {name}")


def check_cells(data, wanted):
    if "volumes" in wanted:
        volumes = data.compute_cell_sizes(length=False, area=False)["Volume"]
        # VTK 9.7 turned wedges round: files for the other side of the change have negative ones.
        turned = wanted["wedges_before_vtk97"] == SINCE_VTK97
        if turned:
            wedges = data.celltypes == vtk.VTK_WEDGE
            if not wedges.any():
                raise Difference("the file should hold wedges")
            volumes = np.where(wedges, -volumes, volumes)
        if len(volumes) != len(wanted["volumes"]):
            raise Difference(f"{len(volumes)} cells instead of {len(wanted['volumes'])}")
        # Not bit by bit: VTK splits polyhedra into tetrahedra of its own.
        if not np.allclose(volumes, wanted["volumes"], rtol=1e-12, atol=0):
            raise Difference(f"volumes {volumes} instead of {wanted['volumes']}")
        if turned:
            return
        validator = vtk.vtkCellValidator()
        validator.SetInputData(data)
        validator.Update()
        states = pyvista.wrap(validator.GetOutput()).cell_data["ValidityState"]
        if np.any(states != 0):
            raise Difference(f"VTK finds invalid cells: {states}")
    if "triangles" in wanted:
        equal(data.regular_faces, wanted["triangles"], "triangles")
    if "origin" in wanted:
        equal(data.origin, wanted["origin"], "origin")
        equal(data.spacing, wanted["spacing"], "spacing")
        equal(np.array(data.dimensions) - 1, wanted["cells"], "cells")


def with_pyvista(path, wanted):
    data = pyvista.read(path)
    if "points" in wanted:
        equal(data.points, wanted["points"], "points")
        if data.n_points and data.points.dtype != np.float64:
            raise Difference(f"points are {data.points.dtype}")
    check_cells(data, wanted)
    columns(data.point_data, wanted.get("point_data", {}), "point data")
    columns(data.cell_data, wanted.get("cell_data", {}), "cell data")
    if wanted.get("time") is not None:
        equal(data.field_data["TimeValue"], [wanted["time"]], "time")
    check_texts(data.field_data, wanted)


def check_texts(field_data, wanted):
    for name, text in wanted.get("texts", {}).items():
        found = bytes(np.asarray(field_data[name])).decode("ascii")
        if found != text:
            raise Difference(f"{name}: '{found}' instead of '{text}'")


def with_meshio(path, wanted):
    with contextlib.redirect_stdout(io.StringIO()):
        mesh = meshio.read(path)
    equal(mesh.points, wanted["points"], "meshio's points")
    if sum(len(block.data) for block in mesh.cells) != len(wanted["volumes"]):
        raise Difference("meshio finds another number of cells")
    columns(mesh.point_data, wanted["point_data"], "meshio's point data")
    # meshio keeps one list for each block of cells of a type.
    joined = {name: np.concatenate(blocks) for name, blocks in mesh.cell_data.items()}
    columns(joined, wanted["cell_data"], "meshio's cell data")
    check_texts(mesh.field_data, wanted)


def same_in_both(path):
    """Opens a result as it is with pyvista and meshio."""
    data = pyvista.read(path)
    with contextlib.redirect_stdout(io.StringIO()):
        mesh = meshio.read(path)
    equal(mesh.points, data.points, "points")
    joined = {name: np.concatenate(blocks) for name, blocks in mesh.cell_data.items()}
    if not joined or set(joined) != set(data.cell_data.keys()):
        raise Difference(f"meshio finds the fields {sorted(joined)}, VTK {sorted(data.cell_data.keys())}")
    for name, values in joined.items():
        equal(values, data.cell_data[name], name)
    settings = bytes(np.asarray(data.field_data["fieldstone"])).decode("ascii")
    if "fieldstone fields with these settings" not in settings:
        raise Difference(f"the settings are '{settings[:80]}'")
    check_texts(mesh.field_data, {"texts": {"fieldstone": settings}})


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    folder = Path(sys.argv[1])
    expected = json.loads((folder / "expected.json").read_text())
    complaints = Complaints()
    opened = by_meshio = 0
    for wanted in expected["files"]:
        path = folder / wanted["file"]
        try:
            with_pyvista(path, wanted)
            opened += 1
            if path.name.startswith(MESHIO_READS) and "_lz4" not in path.name:
                with_meshio(path, wanted)
                by_meshio += 1
        except Difference as difference:
            sys.exit(f"{path}: {difference}")
        if complaints.found:
            sys.exit(f"{path}: {complaints.found[0]}")
    for path in sys.argv[2:]:
        try:
            same_in_both(path)
        except Difference as difference:
            sys.exit(f"{path}: {difference}")
        if complaints.found:
            sys.exit(f"{path}: {complaints.found[0]}")
    series = pyvista.get_reader(folder / expected["series"]["file"])
    equal(series.time_values, expected["series"]["times"], "times of the series")
    series.set_active_time_point(1)
    if series.read()[0].n_cells == 0:
        sys.exit("the second step of the series is empty")
    if opened < 90 or by_meshio < 10:
        sys.exit(f"only {opened} files were compared, {by_meshio} of them with meshio too")
    print(f"VTK {vtk.vtkVersion.GetVTKVersion()} reads all {opened} files as they were meant, meshio {by_meshio}")


if __name__ == "__main__":
    main()
