use fieldstone_geometry::ElementKind;
use thiserror::Error;

/// Why points, faces and cells make no mesh.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeshError {
    /// There is no cell.
    #[error("the mesh has no cell")]
    Empty,
    /// More points, faces or cells than 32-bit labels can name.
    #[error("the mesh has {count} {what}; at most {} are supported", u32::MAX - 1)]
    TooLarge {
        /// `points`, `faces` or `cells`.
        what: &'static str,
        /// How many.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("point {point} is ({}, {}, {}); coordinates must be finite", at[0], at[1], at[2])]
    PointNotFinite {
        /// Index of the point, from 0.
        point: usize,
        /// Its coordinates.
        at: [f64; 3],
    },
    /// A face names a point that does not exist.
    #[error(
        "face {face} names point {point}, but the mesh has {points} points; the points and faces may come from different time steps"
    )]
    PointOutOfRange {
        /// Index of the face, from 0.
        face: usize,
        /// The point that it names.
        point: usize,
        /// Points in the mesh.
        points: usize,
    },
    /// A cell names a point that does not exist.
    #[error("cell {cell} names point {point}, but the mesh has {points} points")]
    CellPointOutOfRange {
        /// Index of the cell, from 0.
        cell: usize,
        /// The point that it names.
        point: usize,
        /// Points in the mesh.
        points: usize,
    },
    /// A face has less than three corners, or one point twice.
    #[error("face {face} has corners {corners:?}; a face needs at least three, all different")]
    BadFace {
        /// Index of the face, from 0.
        face: usize,
        /// Its corners.
        corners: Vec<u32>,
    },
    /// A face of a cell listed by its faces has less than three corners.
    #[error(
        "face {face} of cell {cell} has corners {corners:?}; a face needs at least three: leave it out, or list all of its corners"
    )]
    BadCellFace {
        /// Index of the cell, from 0.
        cell: usize,
        /// Index of the face among the cell's, from 0.
        face: usize,
        /// Its corners.
        corners: Vec<u32>,
    },
    /// The corners that an element repeats leave no body of it.
    #[error(
        "cell {cell} is a {kind} of corners {corners:?}, which enclose nothing since some are the same; leave the cell out, or name corners that differ"
    )]
    Collapsed {
        /// Index of the cell, from 0.
        cell: usize,
        /// Its kind.
        kind: ElementKind,
        /// Its corners in CGNS order; of a polyhedron each face's number of corners and its corners.
        corners: Vec<u32>,
    },
    /// Lists that belong together have different lengths.
    #[error("there are {found} {what}, but {expected} are needed")]
    Count {
        /// What is counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A face names a cell beyond what the faces could enclose.
    #[error(
        "face {face} names cell {cell}, but faces with {most} sides in all enclose at most {most} cells; a label in owner or neighbour may be damaged"
    )]
    CellOutOfRange {
        /// Index of the face, from 0.
        face: usize,
        /// The cell that it names.
        cell: usize,
        /// Owners and neighbours in all: each cell needs at least one of them.
        most: usize,
    },
    /// A face names a cell that does not exist, or its owner twice.
    #[error("face {face} lies between cells {owner} and {neighbour}; two different cells below {cells} are needed")]
    BadCells {
        /// Index of the face, from 0.
        face: usize,
        /// Its owner.
        owner: usize,
        /// Its neighbour.
        neighbour: usize,
        /// Cells in the mesh.
        cells: usize,
    },
    /// An element is given by a wrong number of corners.
    #[error("cell {cell} is a {kind} with {found} corners; it needs {expected}")]
    CornerCount {
        /// Index of the cell, from 0.
        cell: usize,
        /// Its kind.
        kind: ElementKind,
        /// Corners given.
        found: usize,
        /// Corners needed.
        expected: usize,
    },
    /// A polyhedron is given without faces.
    #[error(
        "cell {cell} is a polyhedron without faces; it needs at least those that close it: leave the cell out, or list its faces"
    )]
    NoFaces {
        /// Index of the cell, from 0.
        cell: usize,
    },
    /// The faces of a cell do not close it.
    #[error("cell {cell} has a hole: its edge between points {} and {} belongs to {faces} of its faces instead of 2 that run through it in opposite directions", edge[0], edge[1])]
    OpenCell {
        /// Index of the cell, from 0.
        cell: usize,
        /// The edge's points.
        edge: [u32; 2],
        /// Faces of the cell that have the edge.
        faces: usize,
    },
    /// A face belongs to more than two cells.
    #[error("cells {}, {} and {} share one face (points {corners:?}); at most two may", cells[0], cells[1], cells[2])]
    SharedFace {
        /// Three of the cells.
        cells: [usize; 3],
        /// The face's corners, sorted.
        corners: Vec<u32>,
    },
    /// A cell encloses no volume.
    #[error("cell {cell} encloses no volume (computed: {volume:e})")]
    NoVolume {
        /// Index of the cell, from 0.
        cell: usize,
        /// Its computed volume.
        volume: f64,
    },
    /// Bounds or cell counts of a grid are not usable.
    #[error(
        "the grid has {cells} cells from {low} to {high} along {axis}; give at least 1 cell and finite bounds in rising order"
    )]
    Grid {
        /// Axis name.
        axis: char,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
        /// Cells.
        cells: usize,
    },
    /// Planes of a grid coincide: numbers of this size have too few digits for its cells.
    #[error(
        "planes {plane} and {} of the grid along {axis} fall together at {at}: 64-bit numbers of this size do not resolve {cells} cells; take fewer cells, or coordinates nearer to the origin",
        plane + 1
    )]
    GridPlanes {
        /// Axis name.
        axis: char,
        /// The lower of the two planes, from 0.
        plane: usize,
        /// Where it is.
        at: f64,
        /// Cells along the axis.
        cells: usize,
    },
    /// A set of coordinates that no grid resolves.
    #[error("there are no coordinates '{0}'; choose one of O (all averaged), X, Y, Z, XY, XZ, YZ, XYZ")]
    UnknownCoordinates(String),
    /// A cylindrical grid is not usable.
    #[error(
        "the cylindrical grid has axis {axis}, radii {radii:?}, heights {heights:?} and {cells:?} cells along radius, angle and height; give an axis of 0 to 2, finite rising radii from 0 on, finite rising heights, and at least 1 cell along each"
    )]
    Cylinder {
        /// Direction of the axis.
        axis: usize,
        /// Inner and outer radius.
        radii: [f64; 2],
        /// Lower and upper end.
        heights: [f64; 2],
        /// Cells along radius, angle and height.
        cells: [usize; 3],
    },
}
