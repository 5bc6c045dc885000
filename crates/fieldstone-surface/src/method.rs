use std::fmt;
use std::str::FromStr;

use crate::{
    Dilts, Exact, Geometrical, Haque, Marrone, ScanningCone, SemiGeometrical, Sun, SurfaceDetection, SurfaceError, Wang,
};

/// The methods by name.
///
/// ```
/// use fieldstone_surface::{Method, SurfaceError};
/// let method: Method = "sun".parse()?;
/// assert!(method.supports(2) && !method.supports(3));
/// assert!(matches!("moon".parse::<Method>(), Err(SurfaceError::UnknownMethod { .. })));
/// # Ok::<(), SurfaceError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Method {
    /// [`Exact`].
    #[default]
    Exact,
    /// [`Geometrical`].
    Geometrical,
    /// [`SemiGeometrical`].
    SemiGeometrical,
    /// [`Haque`], three dimensions only.
    Haque,
    /// [`Marrone`].
    Marrone,
    /// [`Wang`].
    Wang,
    /// [`Sun`], two dimensions only.
    Sun,
    /// [`Dilts`], two dimensions only.
    Dilts,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Exact,
        Self::Geometrical,
        Self::SemiGeometrical,
        Self::Haque,
        Self::Marrone,
        Self::Wang,
        Self::Sun,
        Self::Dilts,
    ];

    /// Name, as it is parsed and printed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => Exact::NAME,
            Self::Geometrical => Geometrical::NAME,
            Self::SemiGeometrical => SemiGeometrical::NAME,
            Self::Haque => Haque::NAME,
            Self::Marrone => Marrone::NAME,
            Self::Wang => Wang::NAME,
            Self::Sun => Sun::NAME,
            Self::Dilts => Dilts::NAME,
        }
    }

    /// Whether the method exists in 2 or 3 dimensions.
    pub fn supports(self, dimension: usize) -> bool {
        match self {
            Self::Haque => dimension == Haque::DIMENSION,
            Self::Sun => dimension == Sun::DIMENSION,
            Self::Dilts => dimension == Dilts::DIMENSION,
            _ => dimension == 2 || dimension == 3,
        }
    }

    /// The method with this cone where it has one, and the paper's parameters else.
    ///
    /// # Errors
    /// [`SurfaceError::Option`] for the cone.
    pub fn with_cone(self, cone: ScanningCone) -> Result<Box<dyn SurfaceDetection + Send>, SurfaceError> {
        cone.validate()?;
        Ok(match self {
            Self::Exact => Box::new(Exact::new(cone)?),
            Self::Geometrical => Box::new(Geometrical { cone }),
            Self::SemiGeometrical => Box::new(SemiGeometrical { cone, ..SemiGeometrical::default() }),
            Self::Haque => Box::new(Haque::default()),
            Self::Marrone => Box::new(Marrone::default()),
            Self::Wang => Box::new(Wang::default()),
            Self::Sun => Box::new(Sun { cone }),
            Self::Dilts => Box::new(Dilts::default()),
        })
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Method {
    type Err = SurfaceError;

    fn from_str(name: &str) -> Result<Self, SurfaceError> {
        Self::ALL.into_iter().find(|m| m.name() == name).ok_or_else(|| SurfaceError::UnknownMethod {
            name: name.into(),
            known: Self::ALL.map(Self::name).join(", "),
        })
    }
}
