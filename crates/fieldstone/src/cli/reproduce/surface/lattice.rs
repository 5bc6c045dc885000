//! Fig. 6: position divergence of lattice particles by their layer from planes, edges and corners.

use std::path::Path;

use anyhow::Result;
use fieldstone::io::AtomicFile;
use fieldstone::surface::{Depth, DivergenceThresholds, Kernel, Smoothing, lattice_divergence};

const LAYERS: i32 = 5;
const SMOOTHINGS: [(&str, Smoothing); 2] = [
    ("Wendland C2, h = 2 Δx", Smoothing { kernel: Kernel::WendlandC2, length: 2.0 }),
    ("improved Gaussian, h = 1.5 Δx", Smoothing { kernel: Kernel::ImprovedGaussian, length: 1.5 }),
];
const PLACES: [(&str, usize); 3] = [("plane", 1), ("edge", 2), ("corner", 3)];
/// First and second layer below a plane, from the paper's text.
const PAPER: [f64; 2] = [1.874, 2.571];

pub(super) fn run(folder: &Path) -> Result<String> {
    let value = |smoothing: &Smoothing, axes: usize, layer: i32| {
        let layers = std::array::from_fn(|axis| (axis < axes).then_some(layer));
        lattice_divergence(smoothing, &Depth { layers }, 3)
    };
    AtomicFile::write(&folder.join("fig6.csv"), |out| {
        writeln!(out, "kernel,place,layer,position_divergence")?;
        for (name, smoothing) in &SMOOTHINGS {
            for (place, axes) in PLACES {
                for layer in 1..=LAYERS {
                    writeln!(out, "\"{name}\",{place},{layer},{}", value(smoothing, axes, layer))?;
                }
            }
        }
        Ok(())
    })?;
    let mut text = String::from("## Position divergence on the lattice (Fig. 6)\n\n| kernel | place |");
    (1..=LAYERS).for_each(|layer| text += &format!(" layer {layer} |"));
    text += &format!("\n|---|---|{}\n", "---|".repeat(LAYERS as usize));
    for (name, smoothing) in &SMOOTHINGS {
        for (place, axes) in PLACES {
            text += &format!("| {name} | {place} |");
            (1..=LAYERS).for_each(|layer| text += &format!(" {:.3} |", value(smoothing, axes, layer)));
            text.push('\n');
        }
    }
    let [first, second] = [1, 2].map(|layer| value(&SMOOTHINGS[0].1, 1, layer));
    let agree = [(first, PAPER[0]), (second, PAPER[1])].iter().all(|(a, b)| (a - b).abs() < 5e-4);
    let DivergenceThresholds { free, inner } = DivergenceThresholds::PAPER;
    let margins = DivergenceThresholds::PAPER.margins(&SMOOTHINGS[0].1, 3);
    text += &format!(
        "\nThe paper's values for the first two layers are {} and {}: {}. Its thresholds {free} and {inner} leave {:.3} to the \
         second layer at a corner and {:.3} to the third layer.\n",
        PAPER[0],
        PAPER[1],
        if agree { "the same digits" } else { "not these" },
        margins[0],
        margins[1]
    );
    Ok(text)
}
