//! Free-surface particles of smoothed particle hydrodynamics.

mod arc_cover;
mod cone;
mod detection;
mod dilts;
mod error;
mod exact;
mod exposed_ball;
mod geometrical;
mod haque;
mod intervals;
mod neighbourhood;
mod scan;
mod scene;
mod sun;

pub use cone::ScanningCone;
pub use detection::{Detection, SurfaceDetection, TIE};
pub use dilts::Dilts;
pub use error::SurfaceError;
pub use exact::{Exact, WitnessCache};
pub use geometrical::Geometrical;
pub use haque::Haque;
pub use scene::Scene;
pub use sun::Sun;
