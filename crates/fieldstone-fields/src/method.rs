//! The methods that volume can be binned with.

use std::fmt;
use std::str::FromStr;

use crate::FieldsError;

/// How the volume of a ball is shared out among cells.
///
/// Two are exact; the others are the approximations that are in use elsewhere, so that what exactness buys can
/// be seen on one's own data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Exact, by edge integrals; any polyhedron, any size ratio (`kernel`).
    #[default]
    Kernel,
    /// As `kernel`, in `f64` alone (`kernel-f64`): much faster for balls many times larger than the cells, with errors of
    /// some 1e-15 r³ per cell instead of 1e-12 of the cell.
    KernelF64,
    /// Exact, by caps, wedges and cones (`decomposition`; `strobl2016`, Algorithm 1). Cells that are not planar
    /// tetrahedra, wedges or hexahedra are split into tetrahedra.
    Decomposition,
    /// All of the ball in the cell that holds its centre (`centre`); on a common face that is the upper cell of a grid and the
    /// first one of a mesh.
    Centre,
    /// As `centre`, then each cell's solid fraction averaged with its face neighbours' (`centre-smoothed`;
    /// `lim2006`).
    CentreSmoothed,
    /// The ball as an axis-parallel cube of equal volume (`cube`; `tomiyama1997`).
    Cube,
    /// 29 points of equal volume: the centre and 14 on each of two shells (`divided`; the scheme of CFDEM).
    Divided,
    /// About N points on a regular grid in the ball (`sampled:N`; `fries2011` uses 10 to 20).
    Sampled(u32),
    /// N random points in the ball, the same in every run (`monte-carlo:N`).
    MonteCarlo(u32),
}

impl Method {
    /// Whether the method is exact up to rounding.
    pub fn is_exact(self) -> bool {
        matches!(self, Self::Kernel | Self::KernelF64 | Self::Decomposition)
    }
}

impl FromStr for Method {
    type Err = FieldsError;

    fn from_str(text: &str) -> Result<Self, FieldsError> {
        let count = |n: &str| match n.parse() {
            Ok(n) if (1..=10_000_000).contains(&n) => Ok(n),
            _ => Err(FieldsError::UnknownMethod(text.into())),
        };
        match text.split_once(':') {
            Some(("sampled", n)) => Ok(Self::Sampled(count(n)?)),
            Some(("monte-carlo", n)) => Ok(Self::MonteCarlo(count(n)?)),
            _ => match text {
                "kernel" => Ok(Self::Kernel),
                "kernel-f64" => Ok(Self::KernelF64),
                "decomposition" => Ok(Self::Decomposition),
                "centre" | "center" => Ok(Self::Centre),
                "centre-smoothed" | "center-smoothed" => Ok(Self::CentreSmoothed),
                "cube" => Ok(Self::Cube),
                "divided" => Ok(Self::Divided),
                _ => Err(FieldsError::UnknownMethod(text.into())),
            },
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kernel => f.write_str("kernel"),
            Self::KernelF64 => f.write_str("kernel-f64"),
            Self::Decomposition => f.write_str("decomposition"),
            Self::Centre => f.write_str("centre"),
            Self::CentreSmoothed => f.write_str("centre-smoothed"),
            Self::Cube => f.write_str("cube"),
            Self::Divided => f.write_str("divided"),
            Self::Sampled(n) => write!(f, "sampled:{n}"),
            Self::MonteCarlo(n) => write!(f, "monte-carlo:{n}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_reads_back_its_own_name() {
        use Method::*;
        for m in
            [Kernel, KernelF64, Decomposition, Centre, CentreSmoothed, Cube, Divided, Sampled(20), MonteCarlo(1000)]
        {
            assert_eq!(m.to_string().parse::<Method>().unwrap(), m);
        }
    }

    #[test]
    fn unknown_methods_and_impossible_counts_are_refused_with_the_list() {
        for bad in ["", "exact", "sampled", "sampled:0", "sampled:-3", "monte-carlo:1e9", "cube:4"] {
            let message = bad.parse::<Method>().unwrap_err().to_string();
            assert!(
                message.contains("kernel, kernel-f64, decomposition") && message.contains(&format!("'{bad}'")),
                "{message}"
            );
        }
    }
}
