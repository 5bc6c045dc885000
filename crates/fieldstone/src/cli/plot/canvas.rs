//! Drawing to PNG and SVG alike.

use std::path::Path;

use anyhow::anyhow;
use fieldstone::io::AtomicFile;
use plotters::coord::Shift;
use plotters::prelude::*;

use crate::cli::arguments::ending;
use crate::cli::picture::register_fonts;
use crate::cli::reproduce::plots;

/// A picture, for any kind of file.
pub(super) trait Painting {
    /// Width and height in pixels.
    fn size(&self) -> (u32, u32);

    /// Paints it.
    fn paint<DB: DrawingBackend>(&self, root: &DrawingArea<DB, Shift>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static;
}

/// Writes a picture as .png or .svg.
pub(super) fn save(path: &Path, painting: &impl Painting) -> anyhow::Result<()> {
    if ending(path) != "svg" {
        return plots::save(path, painting.size(), |root| painting.paint(root));
    }
    register_fonts();
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, painting.size()).into_drawing_area();
        painting
            .paint(&root)
            .and_then(|()| Ok(root.present()?))
            .map_err(|e| anyhow!("{}: cannot draw the picture: {e}", path.display()))?;
    }
    AtomicFile::write(path, |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// A number at an axis with as many digits as an axis of this extent needs.
pub(super) fn tick(value: f64, [low, high]: [f64; 2]) -> String {
    let size = low.abs().max(high.abs());
    if size >= 1e5 || (size > 0.0 && size < 1e-3) {
        // Sums of steps leave a rest where zero is meant.
        let value = if value.abs() < 1e-9 * size { 0.0 } else { value };
        let text = format!("{value:.2e}");
        return match text.split_once('e') {
            Some((mantissa, exponent)) => {
                let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
                if value == 0.0 { "0".into() } else { format!("{mantissa}e{exponent}") }
            }
            None => text,
        };
    }
    let decimals = (2.0 - (high - low).abs().max(1e-12).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_have_the_digits_that_the_axis_needs() {
        assert_eq!(tick(0.1 + 0.2, [0.0, 1.0]), "0.3");
        assert_eq!(tick(-1e-17, [-1.0, 1.0]), "0");
        assert_eq!(tick(0.0125, [0.0, 0.05]), "0.0125");
        assert_eq!(tick(2.5e-5, [0.0, 1e-4]), "2.5e-5");
        assert_eq!(tick(1500.0, [0.0, 2000.0]), "1500");
    }
}
