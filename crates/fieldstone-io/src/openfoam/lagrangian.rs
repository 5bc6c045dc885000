//! Particle clouds: `<time>/lagrangian/<cloud>`.

use std::path::{Path, PathBuf};

use fieldstone_particles::{Particles, Quantity};

use crate::{IoError, Position};

use super::list::{Complaint, Item};
use super::locate::{existing, folders, time_of};
use super::stream::Stream;

const BARYCENTRIC_REMEDY: &str = "barycentric coordinates cannot be read without the mesh: \
     convert the cloud (foamToVTK), or write positions too (OpenFOAM.com: writeLagrangianPositions 1 in etc/controlDict)";

/// Reads a particle cloud.
///
/// `path` is a cloud's folder, its `positions` file, a `lagrangian` or time folder with a single cloud, or any file
/// with a list of vectors (`kinematicCloudPositions`). Positions are those of `Cloud<…>` files, `(x y z) cell` in text
/// or binary, or a plain `vectorField`.
///
/// Beside the positions of a cloud, these files are read where they exist:
///
/// | file | becomes |
/// |---|---|
/// | `d` | radius, d/2 |
/// | `U` | quantity `velocity` |
/// | `rho` | quantity `density` |
/// | `nParticle` | quantity `nParticle`: real particles that a parcel stands for |
///
/// The time is that of the time folder's name.
///
/// # Errors
/// [`IoError`] with line or byte. Barycentric coordinates, which mean nothing without the mesh, are refused:
/// `coordinates` of OpenFOAM.com where `positions` is missing, and `positions` of the OpenFOAM Foundation since
/// version 5.
///
/// ```no_run
/// let cloud = fieldstone_io::openfoam::read_cloud("bed/0.1/lagrangian/kinematicCloud".as_ref())?;
/// println!("{} parcels", cloud.len());
/// # Ok::<(), fieldstone_io::IoError>(())
/// ```
pub fn read_cloud(path: &Path) -> Result<Particles, IoError> {
    let file = if path.is_dir() { positions_below(path)? } else { path.to_path_buf() };
    let positions = read_positions(Stream::open(&file)?)?;
    let count = positions.len();
    let wrap = |path: &Path| {
        let path = path.to_path_buf();
        move |source| IoError::Particles { path, source }
    };
    let mut particles = Particles::new(positions).map_err(wrap(&file))?;
    let folder = file.parent().unwrap_or(Path::new("."));
    let is_cloud = file.file_name().is_some_and(|n| n == "positions" || n == "positions.gz");
    if !is_cloud {
        return Ok(particles);
    }
    if let Some(path) = existing(folder, "d") {
        let diameters: Vec<f64> = read_column::<f64>(&path, count)?;
        particles = particles
            .with_radii(diameters.iter().map(|d| d / 2.0).collect())
            .map_err(wrap(&path))?
            .with_source_names("diameter", &["d"]);
    }
    for (name, standard, components) in [("U", "velocity", 3), ("rho", "density", 1), ("nParticle", "nParticle", 1)] {
        let Some(path) = existing(folder, name) else { continue };
        let data = match components {
            3 => read_column::<[f64; 3]>(&path, count)?.into_flattened(),
            _ => read_column::<f64>(&path, count)?,
        };
        particles = particles
            .with_quantity(Quantity { name: standard.into(), components, data })
            .map_err(wrap(&path))?
            .with_source_names(standard, &[name]);
    }
    let time_folder = folder.canonicalize().ok().and_then(|p| Some(p.parent()?.parent()?.to_path_buf()));
    Ok(particles.at(None, time_folder.and_then(|p| time_of(&p))))
}

/// The positions file of the one cloud in or below a folder.
fn positions_below(folder: &Path) -> Result<PathBuf, IoError> {
    if let Some(file) = existing(folder, "positions") {
        return Ok(file);
    }
    if let Some(file) = existing(folder, "coordinates") {
        return Err(IoError::content(
            file,
            Position::File,
            "the cloud has 'coordinates' but no 'positions'",
            BARYCENTRIC_REMEDY,
        ));
    }
    let below = folder.join("lagrangian");
    let below = if below.is_dir() { below } else { folder.to_path_buf() };
    let holds = |p: &Path| ["positions", "coordinates"].iter().any(|n| existing(p, n).is_some());
    let clouds: Vec<_> = folders(&below)?.into_iter().filter(|(_, p)| holds(p)).collect();
    match clouds.as_slice() {
        [(_, cloud)] => positions_below(cloud),
        [] => Err(IoError::content(
            folder,
            Position::File,
            "no particle cloud was found here",
            "give the folder <time>/lagrangian/<cloud>, or a time folder that holds one",
        )),
        many => Err(IoError::content(
            below,
            Position::File,
            format!(
                "there are {} clouds: {}",
                many.len(),
                many.iter().map(|c| c.0.as_str()).collect::<Vec<_>>().join(", ")
            ),
            "name the folder of one of them",
        )),
    }
}

fn read_positions(mut stream: Stream) -> Result<Vec<[f64; 3]>, IoError> {
    use super::list::ListStart::{Empty, Entries, Raw, Uniform};
    let class = stream.header().class.clone();
    if class == "vectorField" || class == "vectorIOField" || class.starts_with("List<vector") {
        return stream.list("positions", 1);
    }
    if !class.contains("Cloud") {
        return Err(stream.error_at(
            0,
            format!("the header says 'class {class}'"),
            "positions are a Cloud<…> or a vectorField",
        ));
    }
    let count = match stream.list_start("particles", false)? {
        Empty => return Ok(Vec::new()),
        Entries(count) => count,
        Raw(_) | Uniform(_) => return Err(stream.unexpected("a list of particles")),
    };
    if stream.encoding().binary {
        return read_raw_positions(stream, count);
    }
    let mut positions: Vec<[f64; 3]> = Vec::new();
    while stream.more_entries("particles", positions.len(), count)? {
        let start = stream.at;
        let position = <[f64; 3]>::from_text(&mut stream).map_err(|e| {
            stream.at = start;
            if stream.accept(b'(') && (0..4).all(|_| stream.scalar().is_ok()) && stream.accept(b')') {
                let found = format!("particle {} has four coordinates, which are barycentric", positions.len());
                return stream.error_at(start, found, BARYCENTRIC_REMEDY);
            }
            e
        })?;
        positions.push(position);
        // The particle's cell and, by version, face and point of its tetrahedron: found anew where needed.
        while stream.peek().is_some_and(|b| b.is_ascii_digit() || b == b'-') {
            stream.integer()?;
        }
    }
    Ok(positions)
}

/// Entries of a binary cloud: position and cell in raw bytes, each entry between parentheses of its own.
fn read_raw_positions(mut stream: Stream, count: Option<usize>) -> Result<Vec<[f64; 3]>, IoError> {
    let encoding = stream.encoding();
    let size = 3 * encoding.scalar + encoding.label;
    let barycentric = 4 * encoding.scalar + 3 * encoding.label;
    let mut positions = Vec::new();
    stream.raw_from = Some(stream.at);
    while stream.more_entries("particles", positions.len(), count)? {
        stream.expect(b'(', "a list of raw particles")?;
        let rest = stream.rest();
        let closed = |n: usize| {
            rest.get(n) == Some(&b')')
                && rest.get(n + 1).is_some_and(|b| b.is_ascii_whitespace() || *b == b')' || *b == b'(')
        };
        if !closed(size) {
            let k = positions.len();
            return Err(if closed(barycentric) {
                stream.error(format!("particle {k} has four coordinates, which are barycentric"), BARYCENTRIC_REMEDY)
            } else {
                stream.error(
                    format!("the entry of particle {k} is not {size} bytes long"),
                    "binary positions hold three scalars and a label: the file is damaged, or of a version that is not supported",
                )
            });
        }
        let bytes = &rest[..3 * encoding.scalar];
        let position = <[f64; 3]>::from_bytes(bytes, &encoding);
        positions.push(position.map_err(|Complaint { found, remedy }| stream.error(found, remedy))?);
        stream.at += size + 1;
    }
    Ok(positions)
}

/// A column with one entry per particle.
fn read_column<T: Item>(path: &Path, count: usize) -> Result<Vec<T>, IoError> {
    let values = Stream::open(path)?.list::<T>("values", count)?;
    if values.len() == count {
        return Ok(values);
    }
    Err(IoError::content(
        path,
        Position::File,
        format!("the file has {} values, but the cloud has {count} particles", values.len()),
        "the files of the cloud may come from different time steps",
    ))
}
