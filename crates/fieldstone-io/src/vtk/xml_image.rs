//! Regular grids of `.vti` files, put together from their pieces.

use super::data::{VtkData, VtkImage};
use super::fault::{Fault, Parsed};
use super::scalar::whole_numbers;
use super::xml_reader::{Arrays, note};
use super::xml_tree::Element;
use crate::{DataArray, Values};

/// First and last point along x, y and z.
type Extent = [[i64; 2]; 3];

pub(super) fn read(arrays: &Arrays<'_>, set: &Element<'_>, data: &mut VtkData) -> Parsed<()> {
    let mut pieces = Vec::new();
    for piece in set.all("Piece") {
        let extent = extent(piece, "Extent")?;
        let image = grid(set, extent)?;
        let (points, cells) = (image.point_count(), image.cell_count());
        let point_data = arrays.columns(piece, "PointData", points, &mut data.skipped)?;
        let cell_data = arrays.columns(piece, "CellData", cells, &mut data.skipped)?;
        pieces.push(Piece { extent, image, point_data, cell_data });
    }
    if pieces.len() <= 1 {
        // The only piece is the grid, also where the file is one process's part of a larger one.
        let Some(piece) = pieces.pop() else {
            return Err(Fault::damaged(set.position(), "there is no <Piece>"));
        };
        data.image = Some(piece.image);
        (data.point_data, data.cell_data) = (piece.point_data, piece.cell_data);
        return Ok(());
    }
    let whole = extent(set, "WholeExtent")?;
    let image = grid(set, whole)?;
    check_cover(&pieces, whole).map_err(|found| Fault::damaged(set.position(), found))?;
    data.point_data = place(&pieces, whole, 1, |p| &p.point_data, &mut data.skipped);
    data.cell_data = place(&pieces, whole, 0, |p| &p.cell_data, &mut data.skipped);
    data.image = Some(image);
    Ok(())
}

/// Whether a piece's range lies in the whole's; one without extent cannot be part of one with extent.
fn within([low, high]: [i64; 2], whole: [i64; 2]) -> bool {
    low >= whole[0] && high <= whole[1] && (low == high) == (whole[0] == whole[1])
}

/// Whether the pieces fill the whole grid. They may overlap: VTK's own writer repeats the whole in each.
fn check_cover(pieces: &[Piece], whole: Extent) -> Result<(), String> {
    if let Some(piece) = pieces.iter().find(|p| !(0..3).all(|k| within(p.extent[k], whole[k]))) {
        return Err(format!("a piece of extent {:?} is no part of the whole, {whole:?}", piece.extent));
    }
    let size = cell_size(&whole);
    let total = size.iter().product::<usize>();
    // Before memory is taken for the whole: columns, whose numbers were counted, must be as large in all.
    let with_columns = pieces.iter().filter(|p| !p.point_data.is_empty() || !p.cell_data.is_empty());
    let counted = with_columns.fold(0_usize, |n, p| n.saturating_add(p.image.cell_count()));
    if counted == 0 {
        return Ok(());
    }
    let mut missing = total;
    if counted >= total {
        let mut filled = vec![false; total];
        for piece in pieces {
            let (at, [nx, ny, nz]) = (offset(&piece.extent, &whole), cell_size(&piece.extent));
            for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
                let row = ((z + at[2]) * size[1] + y + at[1]) * size[0] + at[0];
                filled[row..row + nx].fill(true);
            }
        }
        missing = filled.iter().filter(|&&f| !f).count();
    }
    if missing == 0 { Ok(()) } else { Err(format!("the pieces leave {missing} of {total} cells out")) }
}

/// Cells along each axis; 1 where there is no extent.
fn cell_size(extent: &Extent) -> [usize; 3] {
    extent.map(|[low, high]| ((high - low) as usize).max(1))
}

/// Where a piece starts in the whole.
fn offset(extent: &Extent, whole: &Extent) -> [usize; 3] {
    [0, 1, 2].map(|k| (extent[k][0] - whole[k][0]) as usize)
}

struct Piece {
    extent: Extent,
    image: VtkImage,
    point_data: Vec<DataArray>,
    cell_data: Vec<DataArray>,
}

fn numbers<const N: usize>(element: &Element<'_>, name: &str, default: [f64; N]) -> Parsed<[f64; N]> {
    let Some(text) = element.attribute(name) else { return Ok(default) };
    let parsed: Option<Vec<f64>> = text.split_ascii_whitespace().map(|w| w.parse().ok()).collect();
    parsed.and_then(|v| v.try_into().ok()).ok_or_else(|| {
        element.fault(format!("{name}=\"{text}\" in <{}>", element.name), "write as many numbers there as VTK does")
    })
}

fn extent(element: &Element<'_>, name: &str) -> Parsed<Extent> {
    let fault = |text: &str| Fault::damaged(element.position(), format!("{name}=\"{text}\" in <{}>", element.name));
    let text = element.attribute(name).ok_or_else(|| fault(""))?;
    let parsed: Option<Vec<i64>> = text.split_ascii_whitespace().map(|w| w.parse().ok()).collect();
    let parsed: Option<[i64; 6]> = parsed.and_then(|v| v.try_into().ok());
    let [a, b, c, d, e, f] = parsed.ok_or_else(|| fault(text))?;
    let extent = [[a, b], [c, d], [e, f]];
    // Bounds that keep every product of counts within 64 bits.
    if extent.iter().any(|&[low, high]| low > high || low.abs() > 1 << 20 || high.abs() > 1 << 20) {
        return Err(fault(text));
    }
    Ok(extent)
}

fn grid(set: &Element<'_>, extent: Extent) -> Parsed<VtkImage> {
    let origin: [f64; 3] = numbers(set, "Origin", [0.0; 3])?;
    let spacing: [f64; 3] = numbers(set, "Spacing", [1.0; 3])?;
    let d: [f64; 9] = numbers(set, "Direction", [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])?;
    let direction = [[d[0], d[1], d[2]], [d[3], d[4], d[5]], [d[6], d[7], d[8]]];
    let step = [0, 1, 2].map(|k| extent[k][0] as f64 * spacing[k]);
    // VTK's origin belongs to index 0, which need not be part of the extent.
    let first = [0, 1, 2].map(|k| origin[k] + (0..3).map(|m| direction[k][m] * step[m]).sum::<f64>());
    let cells = extent.map(|[low, high]| (high - low) as usize);
    Ok(VtkImage { origin: first, spacing, cells, direction })
}

/// Columns of the whole grid from those of its pieces; `points` is 1 for point data, 0 for cell data.
fn place(
    pieces: &[Piece],
    whole: Extent,
    points: usize,
    columns: impl Fn(&Piece) -> &Vec<DataArray>,
    skipped: &mut Vec<String>,
) -> Vec<DataArray> {
    let size = |e: &Extent| e.map(|[low, high]| ((high - low) as usize + points).max(1));
    let whole_size = size(&whole);
    let mut all = Vec::new();
    for first in columns(&pieces[0]) {
        let same = |c: &&DataArray| c.name == first.name && c.components == first.components;
        let parts: Vec<&DataArray> = pieces.iter().filter_map(|p| columns(p).iter().find(same)).collect();
        if parts.len() != pieces.len() {
            note(skipped, &first.name);
            continue;
        }
        let n = first.components;
        let mut target = vec![0.0; whole_size.iter().product::<usize>() * n];
        for (piece, part) in pieces.iter().zip(&parts) {
            let from = part.values.to_f64();
            let [nx, ny, nz] = size(&piece.extent);
            let at = offset(&piece.extent, &whole);
            for z in 0..nz {
                for y in 0..ny {
                    let source = (z * ny + y) * nx * n;
                    let row = ((z + at[2]) * whole_size[1] + y + at[1]) * whole_size[0] + at[0];
                    target[row * n..(row + nx) * n].copy_from_slice(&from[source..source + nx * n]);
                }
            }
        }
        let values = match first.values {
            Values::F32(_) => Values::F32(target.into_iter().map(|x| x as f32).collect()),
            Values::F64(_) => Values::F64(target),
            Values::I64(_) | Values::U8(_) => {
                let whole = whole_numbers(&Values::F64(target.clone()));
                whole.map_or(Values::F64(target), Values::I64)
            }
        };
        all.push(DataArray { name: first.name.clone(), components: n, values });
    }
    all
}
