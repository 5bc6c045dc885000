//! The box of a LIGGGHTS or LAMMPS dump: orthogonal, tilted, or given by three edge vectors.

use fieldstone_particles::Domain;

use crate::IoError;
use crate::lines::{LineReader, number, shown, words};

/// Origin, edge vectors and boundary flags.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DumpBox {
    origin: [f64; 3],
    edges: [[f64; 3]; 3],
    /// Upper corner without the tilt; as the file states it where there is none.
    high: [f64; 3],
    /// `None` in files older than the flags.
    periodic: Option<[bool; 3]>,
}

impl DumpBox {
    /// Reads the three lines after the `ITEM: BOX BOUNDS` line, which `lines` stands at.
    pub(crate) fn read(lines: &mut LineReader) -> Result<Self, IoError> {
        let header: Vec<String> = words(lines.line()).skip(3).map(shown).collect();
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        let (numbers, flags) = match header.as_slice() {
            ["xy", "xz", "yz", flags @ ..] => (3, flags),
            ["abc", "origin", flags @ ..] => (4, flags),
            flags => (2, flags),
        };
        let periodic = match flags {
            [] => None,
            [x, y, z] if flags.iter().all(|f| f.len() <= 2 && f.bytes().all(|b| b"pfsm".contains(&b))) => {
                Some([*x, *y, *z].map(|flag| flag.starts_with('p')))
            }
            _ => {
                let found =
                    format!("the box's boundary flags are '{}'; three like pp, ff, fs are expected", flags.join(" "));
                return Err(lines.error(found, "write the file again"));
            }
        };
        let mut rows = [[0.0; 4]; 3];
        for row in &mut rows {
            if !lines.advance()? {
                return Err(lines.error("the file ends within the box", "the file is cut: write it again"));
            }
            let found: Vec<Option<f64>> = words(lines.line()).map(|w| number(w).filter(|v| v.is_finite())).collect();
            if found.len() != numbers || found.contains(&None) {
                let found = format!("the box needs {numbers} numbers in this line, found '{}'", shown(lines.line()));
                return Err(lines.error(found, "write the file again"));
            }
            for (slot, value) in row.iter_mut().zip(found.into_iter().flatten()) {
                *slot = value;
            }
        }
        Ok(match numbers {
            2 => Self::orthogonal(rows.map(|r| r[0]), rows.map(|r| r[1]), periodic),
            3 => Self::tilted(rows, periodic),
            _ => Self::general(rows, periodic),
        })
    }

    fn orthogonal(low: [f64; 3], high: [f64; 3], periodic: Option<[bool; 3]>) -> Self {
        let mut edges = [[0.0; 3]; 3];
        for axis in 0..3 {
            edges[axis][axis] = high[axis] - low[axis];
        }
        Self { origin: low, edges, high, periodic }
    }

    /// The file states the bounds of the axis-aligned box around the tilted one, so the tilt is taken off
    /// before the edges are known.
    fn tilted(rows: [[f64; 4]; 3], periodic: Option<[bool; 3]>) -> Self {
        let [xy, xz, yz] = rows.map(|r| r[2]);
        if [xy, xz, yz] == [0.0; 3] {
            return Self::orthogonal(rows.map(|r| r[0]), rows.map(|r| r[1]), periodic);
        }
        let x = [0.0, xy, xz, xy + xz];
        let low = [rows[0][0] - x.into_iter().fold(0.0, f64::min), rows[1][0] - yz.min(0.0), rows[2][0]];
        let high = [rows[0][1] - x.into_iter().fold(0.0, f64::max), rows[1][1] - yz.max(0.0), rows[2][1]];
        let edges = [[high[0] - low[0], 0.0, 0.0], [xy, high[1] - low[1], 0.0], [xz, yz, high[2] - low[2]]];
        Self { origin: low, edges, high, periodic }
    }

    fn general(rows: [[f64; 4]; 3], periodic: Option<[bool; 3]>) -> Self {
        let edges = rows.map(|r| [r[0], r[1], r[2]]);
        let origin = rows.map(|r| r[3]);
        let high = std::array::from_fn(|k| origin[k] + edges[k][k]);
        Self { origin, edges, high, periodic }
    }

    /// The box, and the reason where it cannot be kept.
    pub(crate) fn domain(&self) -> Result<Domain, BoxFault> {
        let periodic = self.periodic.unwrap_or_default();
        let [[lx, ay, az], [xy, ly, bz], [xz, yz, lz]] = self.edges;
        if [ay, az, bz] != [0.0; 3] {
            return Err(BoxFault::Turned { periodic: self.periodic != Some([false; 3]) });
        }
        let domain = if [xy, xz, yz] == [0.0; 3] {
            Domain::new(self.origin, self.high, periodic)
        } else {
            Domain::triclinic(self.origin, [lx, ly, lz], [xy, xz, yz], periodic)
        };
        domain.map_err(|e| BoxFault::Empty(e.to_string()))
    }

    /// Whether the file says which directions are periodic.
    pub(crate) fn flagged(&self) -> bool {
        self.periodic.is_some()
    }

    /// The point with coordinates that are fractions of the edges.
    pub(crate) fn place(&self, fraction: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| {
            let [a, b, c] = [0, 1, 2].map(|edge| fraction[edge] * self.edges[edge][k]);
            self.origin[k] + (a + b + c)
        })
    }
}

/// Why a box is no [`Domain`].
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum BoxFault {
    /// Its first edge is not along x, or its second not in the plane of x and y.
    Turned {
        periodic: bool,
    },
    Empty(String),
}
