#!/usr/bin/env python3
"""Writes small VTK files in every encoding that VTK has, and the numbers that a reader must find in them.

    python tools/vtk_fixtures.py [FOLDER]

FOLDER is crates/fieldstone-io/tests/fixtures/vtk unless given. Needs the `vtk` package, 9.4 or newer: older
ones write polyhedra in the old layout only. Numbers go into one `.expected` file per content, which files of
that content name in `index.txt`. Each line of an expected file is a name, the numbers per point or cell, and
the numbers, written with 17 digits.
"""

import itertools
import math
import re
import struct
import sys
from pathlib import Path

import vtk
from vtkmodules.util.numpy_support import numpy_to_vtk
import numpy as np

DEFAULT = Path(__file__).resolve().parent.parent / "crates/fieldstone-io/tests/fixtures/vtk"


def array(name, numbers):
    new = numpy_to_vtk(np.ascontiguousarray(numbers), deep=1)
    new.SetName(name)
    return new


def points(coordinates, dtype):
    new = vtk.vtkPoints()
    new.SetData(array("Points", np.asarray(coordinates, dtype=dtype)))
    return new


def irregular(n, seed, dtype=np.float64):
    """Numbers without pattern that every float type holds exactly in 24 bits."""
    k = np.arange(n, dtype=np.int64)
    return (((k * 7919 + seed * 104729) % 65521) / 4096.0 - 8.0).astype(dtype)


def add_columns(data, dtype):
    n, cells = data.GetNumberOfPoints(), data.GetNumberOfCells()
    data.GetPointData().AddArray(array("radius", 10.0 + irregular(n, 1, dtype)))
    data.GetPointData().AddArray(array("v", irregular(3 * n, 2, dtype).reshape(n, 3)))
    data.GetPointData().AddArray(array("id", np.arange(n, dtype=np.int32) * 3 - 5))
    for k, kind in enumerate((np.int8, np.uint8, np.int16, np.uint16, np.int32, np.uint32, np.int64, np.uint64)):
        # The first two show that the sign and the whole width survive.
        high = np.iinfo(kind).max >> 1
        low = -high if np.iinfo(kind).min < 0 else 1
        values = np.arange(cells) * 37 % 100 + k
        values[:2] = low, high
        data.GetCellData().AddArray(array(kind.__name__, values.astype(kind)))
    data.GetCellData().AddArray(array("alpha beta", irregular(cells, 3, dtype)))
    data.GetFieldData().AddArray(array("TimeValue", np.array([0.125])))


HEX = [0, 1, 3, 2, 4, 5, 7, 6]
CUBE_FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]


def insert_polyhedron(grid, faces):
    stream = vtk.vtkIdList()
    stream.InsertNextId(len(faces))
    for face in faces:
        for number in [len(face), *face]:
            stream.InsertNextId(number)
    grid.InsertNextCell(vtk.VTK_POLYHEDRON, stream)


def mixed(dtype, polyhedra=True):
    """A tower of unit cubes along x: hexahedron, voxel, two wedges, a pyramid with tetrahedra, polyhedra.

    Vertices, a line, a triangle and a quadrilateral stand between them. Volumes are those that a reader must
    find in the three-dimensional cells.
    """
    grid = vtk.vtkUnstructuredGrid()
    place = [(x, y, z) for x in range(7) for z in range(2) for y in range(2)]
    centre = len(place)
    place.append((2.5, 0.5, 0.5))
    tip = len(place)
    place.append((6.5, 0.5, 0.5))
    number = {p: k for k, p in enumerate(place)}
    grid.SetPoints(points(place, dtype))

    def cube(x):
        """Corners as a voxel lists them."""
        return [number[(x + i, j, k)] for k in (0, 1) for j in (0, 1) for i in (0, 1)]

    volumes = []

    def insert(kind, corners, volume):
        grid.InsertNextCell(kind, len(corners), corners)
        if volume:
            volumes.append(volume)

    insert(vtk.VTK_VERTEX, [0], None)
    insert(vtk.VTK_VOXEL, cube(0), 1.0)
    insert(vtk.VTK_LINE, [0, 1], None)
    c = cube(1)
    insert(vtk.VTK_HEXAHEDRON, [c[k] for k in HEX], 1.0)
    insert(vtk.VTK_TRIANGLE, [0, 1, 2], None)
    # Six pyramids around the centre of the third cube; one of them as two tetrahedra.
    c = cube(2)
    for face in CUBE_FACES[:-1]:
        insert(vtk.VTK_PYRAMID, [c[k] for k in face[::-1]] + [centre], 1.0 / 6.0)
    a, b, d, e = (c[k] for k in CUBE_FACES[-1][::-1])
    insert(vtk.VTK_TETRA, [a, b, d, centre], 1.0 / 12.0)
    insert(vtk.VTK_TETRA, [a, d, e, centre], 1.0 / 12.0)
    c = cube(3)
    insert(vtk.VTK_QUAD, [c[0], c[1], c[3], c[2]], None)
    # VTK 9.7 reversed the winding of wedges, and files do not say which they have: one of each.
    insert(vtk.VTK_WEDGE, [c[0], c[2], c[1], c[4], c[6], c[5]], 0.5)
    insert(vtk.VTK_WEDGE, [c[1], c[3], c[2], c[5], c[7], c[6]], 0.5)
    if polyhedra:
        for x in (4, 5):
            c = cube(x)
            faces = [[c[k] for k in face] for face in CUBE_FACES]
            if x == 5:
                # A roof instead of the last face: nine faces, a cell that no standard type can hold.
                last = faces.pop(3)
                faces += [[last[k], last[(k + 1) % 4], tip] for k in range(4)]
            insert_polyhedron(grid, faces)
            volumes.append(1.0 if x == 4 else 1.0 + 0.5 / 3.0)
    add_columns(grid, dtype)
    return grid, volumes


def surface(dtype):
    data = vtk.vtkPolyData()
    place = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)]
    data.SetPoints(points(place, dtype))
    sections = [vtk.vtkCellArray() for _ in range(4)]
    for section, cells in zip(sections, ([[4], [0, 1]], [[0, 1], [0, 1, 2]], [[0, 1, 4], [0, 1, 2, 3]], [[0, 1, 3, 2]])):
        for cell in cells:
            section.InsertNextCell(len(cell), cell)
    data.SetVerts(sections[0])
    data.SetLines(sections[1])
    data.SetPolys(sections[2])
    data.SetStrips(sections[3])
    add_columns(data, dtype)
    return data


def image(dtype):
    data = vtk.vtkImageData()
    data.SetExtent(1, 4, -1, 1, 0, 2)
    data.SetOrigin(0.5, 0.25, -1.0)
    data.SetSpacing(0.5, 0.25, 2.0)
    add_columns(data, dtype)
    return data


WRITERS = {
    "vtu": vtk.vtkXMLUnstructuredGridWriter,
    "vtp": vtk.vtkXMLPolyDataWriter,
    "vti": vtk.vtkXMLImageDataWriter,
}


def write_xml(path, data, mode, compressor, header, order="LittleEndian", pieces=1):
    writer = WRITERS[path.suffix[1:]]()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    # Several blocks for the larger arrays, so that whole and partial blocks both occur.
    writer.SetBlockSize(256)
    if mode == "ascii":
        writer.SetDataModeToAscii()
    elif mode == "inline":
        writer.SetDataModeToBinary()
    else:
        writer.SetDataModeToAppended()
        writer.SetEncodeAppendedData(mode == "base64")
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    getattr(writer, f"SetHeaderTypeTo{header}")()
    getattr(writer, f"SetByteOrderTo{order}")()
    if pieces > 1:
        writer.SetNumberOfPieces(pieces)
    assert writer.Write() == 1, path


def numbers(values):
    values = np.asarray(values).reshape(-1)
    if values.dtype.kind in "iu":
        return " ".join(str(int(v)) for v in values)
    return " ".join(repr(float(v)) for v in values)


def as_numpy(vtk_array):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(vtk_array)


def expected(data, volumes):
    lines = []
    if isinstance(data, vtk.vtkImageData):
        extent = data.GetExtent()
        spacing = np.array(data.GetSpacing())
        first = np.array(data.GetOrigin()) + spacing * extent[::2]
        lines.append(f"image.origin 3 {numbers(first)}")
        lines.append(f"image.spacing 3 {numbers(spacing)}")
        lines.append(f"image.cells 3 {numbers(np.array(extent[1::2]) - np.array(extent[::2]))}")
    else:
        lines.append(f"points 3 {numbers(as_numpy(data.GetPoints().GetData()))}")
        kinds = [data.GetCellType(k) for k in range(data.GetNumberOfCells())]
        lines.append(f"cells.types 1 {numbers(kinds)}")
        corners, ends = [], []
        for k, kind in enumerate(kinds):
            cell = data.GetCell(k).GetPointIds()
            ids = [cell.GetId(i) for i in range(cell.GetNumberOfIds())]
            # The order of a polyhedron's corners means nothing.
            corners += sorted(ids) if kind == vtk.VTK_POLYHEDRON else ids
            ends.append(len(corners))
        lines.append(f"cells.corners 1 {numbers(np.array(corners, dtype=int))}")
        lines.append(f"cells.ends 1 {numbers(np.array(ends, dtype=int))}")
    for location, fields in (("point", data.GetPointData()), ("cell", data.GetCellData()), ("field", data.GetFieldData())):
        for k in range(fields.GetNumberOfArrays()):
            a = fields.GetArray(k)
            if a is None:  # texts
                continue
            name = a.GetName().replace(" ", "_")
            lines.append(f"{location}.{name} {a.GetNumberOfComponents()} {numbers(as_numpy(a))}")
    if volumes:
        lines.append(f"volumes 1 {numbers(np.array(volumes))}")
    return "\n".join(lines) + "\n"


def old_polyhedra(text):
    """Rewrites the polyhedra of an XML text file in the layout that VTK had before 9.4."""

    def take(name):
        nonlocal text
        found = re.search(rf'\s*<DataArray type="Int64" Name="{name}"[^>]*>([^<]*)</DataArray>', text)
        text = text[: found.start()] + text[found.end() :]
        return [int(w) for w in found[1].split()]

    corners, ends, cell_faces, cell_ends = map(
        take, ("face_connectivity", "face_offsets", "polyhedron_to_faces", "polyhedron_offsets")
    )
    faces = [corners[a:b] for a, b in itertools.pairwise([0, *ends])]
    stream, offsets = [], []
    for a, b in itertools.pairwise([0, *cell_ends]):
        if a == b:
            offsets.append(-1)
            continue
        stream.append(b - a)
        for face in cell_faces[a:b]:
            stream += [len(faces[face]), *faces[face]]
        offsets.append(len(stream))
    new = "".join(
        f'<DataArray type="Int64" Name="{name}" format="ascii">\n{" ".join(map(str, values))}\n</DataArray>\n'
        for name, values in (("faces", stream), ("faceoffsets", offsets))
    )
    text = text.replace("</Cells>", new + "</Cells>")
    return re.sub(r'version="2\.\d"', 'version="1.0"', text)


def check_reads(path):
    """VTK itself must accept what was rewritten by hand."""
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    faces = [grid.GetCell(k).GetNumberOfFaces() for k in range(grid.GetNumberOfCells())]
    assert 9 in faces, (path, faces)


def write_legacy(path, data, version, binary):
    writer = {
        "vtkUnstructuredGrid": vtk.vtkUnstructuredGridWriter,
        "vtkPolyData": vtk.vtkPolyDataWriter,
        "vtkImageData": vtk.vtkStructuredPointsWriter,
    }[data.GetClassName()]()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    writer.SetFileVersion(version)
    writer.SetFileTypeToBinary() if binary else writer.SetFileTypeToASCII()
    assert writer.Write() == 1, path


def read_back(reader, path):
    reader = reader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def write_image_parts(path, data, extents):
    """One file of which each piece holds a part of the grid."""
    write_xml(path, data, "ascii", "None", "UInt32")
    text = path.read_text()
    parts = ""
    for extent in extents:
        part = vtk.vtkExtractVOI()
        part.SetInputData(data)
        part.SetVOI(*extent)
        part.Update()
        write_xml(path, part.GetOutput(), "ascii", "None", "UInt32")
        found = re.search(r"<Piece.*</Piece>\n", path.read_text(), re.DOTALL)[0]
        parts += re.sub(r'Extent="[^"]*"', f'Extent="{" ".join(map(str, extent))}"', found, count=1)
    path.write_text(re.sub(r"<Piece.*</Piece>\n", parts, text, flags=re.DOTALL))
    assert expected(read_back(vtk.vtkXMLImageDataReader, path), None) == expected(data, None), path


def write_two_pieces(path, single):
    """The piece of an XML text file twice, so that cells of the second must be shifted."""
    text = single.read_text()
    piece = re.search(r"<Piece.*</Piece>\n", text, re.DOTALL)[0]
    # VTK sorts the cells of all pieces by kind; with polygons alone, that keeps their order.
    for name in ("Verts", "Lines", "Strips"):
        piece = re.sub(rf"<{name}>.*</{name}>", "", piece, flags=re.DOTALL)
        piece = re.sub(rf'NumberOf{name}="\d+"', f'NumberOf{name}="0"', piece)
    piece = re.sub(r"<CellData>.*</CellData>", "", piece, flags=re.DOTALL)
    path.write_text(re.sub(r"<Piece.*</Piece>\n", piece + piece, text, flags=re.DOTALL))


def with_attributes():
    """A legacy file with every kind of attribute that has a keyword of its own."""
    data = vtk.vtkPolyData()
    data.SetPoints(points([(0, 0, 0), (1, 2, 3)], np.float32))
    verts = vtk.vtkCellArray()
    for k in range(2):
        verts.InsertNextCell(1, [k])
    data.SetVerts(verts)
    fields = data.GetPointData()
    fields.SetScalars(array("s", np.array([1.5, -2.5])))
    fields.SetVectors(array("u", np.arange(6, dtype=np.float32).reshape(2, 3)))
    fields.SetNormals(array("n", np.array([[0, 0, 1.0], [1, 0, 0]])))
    fields.SetTensors(array("stress", np.arange(18, dtype=np.float64).reshape(2, 9)))
    fields.SetTCoords(array("uv", np.array([[0.25, 0.5], [0.75, 1.0]])))
    words = vtk.vtkStringArray()
    words.SetName("names")
    for text in ("one", "a much longer name " * 4):
        words.InsertNextValue(text)
    data.GetCellData().AddArray(words)
    data.GetCellData().AddArray(array("after_names", np.array([3.0, 4.0])))
    return data


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    index = []

    def content(name, data, volumes=None):
        (folder / f"{name}.expected").write_text(expected(data, volumes))

    def add(name, of):
        index.append(f"{name} {of}")

    contents = {}
    for dtype, tag in ((np.float64, "f64"), (np.float32, "f32")):
        grid, volumes = mixed(dtype)
        plain, plain_volumes = mixed(dtype, polyhedra=False)
        contents[f"mixed_{tag}"] = (grid, volumes, "vtu")
        contents[f"plain_{tag}"] = (plain, plain_volumes, "vtu")
        contents[f"surface_{tag}"] = (surface(dtype), None, "vtp")
        contents[f"image_{tag}"] = (image(dtype), None, "vti")
    contents["attributes"] = (with_attributes(), None, None)
    for name, (data, volumes, _) in contents.items():
        content(name, data, volumes)

    every = list(itertools.product(("inline", "base64", "raw"), ("None", "ZLib", "LZ4", "LZMA"), ("UInt32", "UInt64")))
    every.append(("ascii", "None", "UInt32"))
    for name, (data, _, suffix) in contents.items():
        if suffix is None:
            continue
        # The mesh comes in every encoding, the others in those that differ in more than the header's width.
        chosen = every if name == "mixed_f64" else [
            e for e in every if e[2] == "UInt32" and e[0] != "base64"
        ]
        if name.endswith("f32"):
            chosen = [e for e in every if e[1] == "LZ4" or e[0] == "ascii"] if name.startswith("mixed") else [("raw", "ZLib", "UInt64")]
        if name.startswith("plain"):
            chosen = [("raw", "ZLib", "UInt64"), ("inline", "None", "UInt32")]
        for mode, compressor, header in chosen:
            path = folder / f"{name}_{mode}_{compressor}_{header}.{suffix}".lower()
            write_xml(path, data, mode, compressor, header)
            add(path.name, name)
        for mode, compressor in (("inline", "None"), ("base64", "ZLib"), ("raw", "LZ4")):
            if name.endswith("f64"):
                path = folder / f"{name}_{mode}_{compressor}_big.{suffix}".lower()
                write_xml(path, data, mode, compressor, "UInt32", "BigEndian")
                add(path.name, name)
    old = folder / "mixed_f64_old_polyhedra.vtu"
    old.write_text(old_polyhedra((folder / "mixed_f64_ascii_none_uint32.vtu").read_text()))
    check_reads(old)
    add(old.name, "mixed_f64")

    # VTK's own writer repeats the whole in every piece; parallel programs write real parts.
    pieces = folder / "image_f64_whole_pieces.vti"
    write_xml(pieces, contents["image_f64"][0], "raw", "ZLib", "UInt64", pieces=3)
    assert pieces.read_bytes().count(b"<Piece ") == 3
    add(pieces.name, "image_f64")
    pieces = folder / "image_f64_parts.vti"
    write_image_parts(pieces, contents["image_f64"][0], [(1, 2, -1, 1, 0, 2), (2, 4, -1, 0, 0, 2), (2, 4, 0, 1, 0, 2)])
    add(pieces.name, "image_f64")
    pieces = folder / "surface_f64_two_pieces.vtp"
    write_two_pieces(pieces, folder / "surface_f64_ascii_none_uint32.vtp")
    add(pieces.name, "surface_f64_twice")
    content("surface_f64_twice", read_back(vtk.vtkXMLPolyDataReader, pieces))

    for name in ("mixed_f64", "plain_f32", "surface_f64", "image_f64", "attributes"):
        for version, binary in itertools.product((42, 51), (False, True)):
            path = folder / f"{name}_{version}_{'binary' if binary else 'text'}.vtk"
            write_legacy(path, contents[name][0], version, binary)
            add(path.name, name)

    (folder / "index.txt").write_text("\n".join(sorted(index)) + "\n")
    total = sum(f.stat().st_size for f in folder.iterdir())
    print(f"{len(index)} files, {total} bytes in {folder}")


if __name__ == "__main__":
    main()
