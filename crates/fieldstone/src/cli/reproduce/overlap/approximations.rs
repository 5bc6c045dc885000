//! Error and smoothness of the approximations, as a ball crosses a cell.

use anyhow::Result;
use fieldstone::fields::{Method, Weights};
use fieldstone::io::AtomicFile;
use fieldstone::mesh::{Cells, Grid};
use fieldstone::particles::Particles;
use plotters::chart::SeriesLabelPosition;

use super::plots::{Axis, COLOURS, Curve, Plot, draw};
use super::{Settings, progress};
use crate::cli::reproduce::random::SplitMix;

/// Radius of the ball in sides of a cell: the paper's ratio of side to diameter, 1/0.6.
const RADIUS: f64 = 0.3;
/// Where the ball's path lies in the cell, off its middle so that other cells get a share.
const OFFSET: [f64; 2] = [0.31, 0.17];
const STEPS: u32 = 480;
const EXACT: Method = Method::Kernel;
const METHODS: [Method; 6] =
    [EXACT, Method::Centre, Method::CentreSmoothed, Method::Cube, Method::Divided, Method::Sampled(20)];

pub(super) fn run(settings: &Settings) -> Result<String> {
    let bar = progress(METHODS.len() as u64 * 2, "crossing")?;
    // The cell around the origin, with two more on each side.
    let grid = Grid::new([-2.5; 3], [2.5; 3], [5; 3])?;
    let home = grid.locate([0.0; 3], &mut grid.scratch()).unwrap_or_default();
    let positions: Vec<f64> = (0..=STEPS).map(|k| 2.0 * f64::from(k) / f64::from(STEPS) - 1.0).collect();
    let path = Particles::new(positions.iter().map(|&x| [x, OFFSET[0], OFFSET[1]]).collect())?;
    let path = path.with_uniform_radius(RADIUS)?;
    let random = random_positions()?;
    let (mut shares, mut random_shares) = (Vec::new(), Vec::new());
    for method in METHODS {
        shares.push(shares_of(&grid, &path, method, home)?);
        bar.inc(1);
        random_shares.push(shares_of(&grid, &random, method, home)?);
        bar.inc(1);
    }
    bar.finish_and_clear();

    AtomicFile::write(&settings.folder.join("approximations.csv"), |out| {
        write!(out, "x")?;
        for method in METHODS {
            write!(out, ",share_{method}")?;
        }
        for method in &METHODS[1..] {
            write!(out, ",error_{method}")?;
        }
        writeln!(out)?;
        for (k, x) in positions.iter().enumerate() {
            write!(out, "{x}")?;
            for share in &shares {
                write!(out, ",{}", share[k])?;
            }
            for share in &shares[1..] {
                write!(out, ",{:e}", share[k] - shares[0][k])?;
            }
            writeln!(out)?;
        }
        Ok(())
    })?;
    draw(&settings.folder.join("approximations.png"), &plots(&positions, &shares))?;
    Ok(section(&shares, &random_shares))
}

/// Part of each particle that a method puts into the cell `home`.
fn shares_of(grid: &Grid, particles: &Particles, method: Method, home: u32) -> Result<Vec<f64>> {
    let weights = Weights::build(grid, particles, method, None)?;
    Ok((0..particles.len())
        .map(|k| {
            let (cells, volumes) = weights.row(k);
            let volume = cells.iter().position(|&c| c == home).map_or(0.0, |at| volumes[at]);
            volume / weights.particle_volumes()[k]
        })
        .collect())
}

/// Balls of this radius in reach of the cell, and no more of the approximations than their worst case.
fn random_positions() -> Result<Particles> {
    let mut random = SplitMix::new(7);
    let reach = 0.5 + RADIUS;
    let at = |random: &mut SplitMix| reach * (2.0 * random.uniform() - 1.0);
    let centres = (0..100_000).map(|_| [at(&mut random), at(&mut random), at(&mut random)]).collect();
    Ok(Particles::new(centres)?.with_uniform_radius(RADIUS)?)
}

fn plots(positions: &[f64], shares: &[Vec<f64>]) -> Vec<Plot> {
    let x = Axis { name: "position of the ball / side of the cell", range: [-1.0, 1.0], logarithmic: false };
    let curve = |index: usize, points: Vec<(f64, f64)>| Curve {
        name: if index == 0 { "exact (kernel)".into() } else { METHODS[index].to_string() },
        points,
        colour: COLOURS[index],
        dashed: index > 0,
    };
    let along = |value: &dyn Fn(usize) -> f64| positions.iter().enumerate().map(|(k, &x)| (x, value(k))).collect();
    let part = Plot {
        title: format!("part of a ball of radius {RADIUS} in the cell"),
        x,
        y: Axis { name: "volume in the cell / volume of the ball", range: [0.0, 1.1], logarithmic: false },
        curves: (0..METHODS.len()).map(|m| curve(m, along(&|k| shares[m][k]))).collect(),
        legend: Some(SeriesLabelPosition::UpperRight),
    };
    let error = Plot {
        title: "error of the approximations".into(),
        x,
        y: Axis { name: "|error| / volume of the ball", range: [1e-5, 1.0], logarithmic: true },
        curves: (1..METHODS.len()).map(|m| curve(m, along(&|k| (shares[m][k] - shares[0][k]).abs()))).collect(),
        legend: None,
    };
    vec![part, error]
}

fn section(shares: &[Vec<f64>], random: &[Vec<f64>]) -> String {
    let mut text = format!(
        "## The approximations\n\n![A ball crosses a cell](approximations.png)\n\nA ball of radius {RADIUS} sides crosses a \
         cubic cell in {STEPS} steps along x, at y = {}, z = {}. “Jump” is the largest change from one step to the \
         next, in shares of the ball: a smooth field needs small ones. The worst errors are those over 100,000 \
         random positions around the cell, relative to the ball's volume and to the exact overlap, the latter where at \
         least a tenth of the ball is in the cell.\n\n| method | worst error on the path | largest jump | worst error \
         / ball | worst error / overlap |\n|---|---|---|---|---|\n",
        OFFSET[0], OFFSET[1]
    );
    for (m, method) in METHODS.iter().enumerate() {
        let errors = |of: &[Vec<f64>]| -> Vec<(f64, f64)> {
            of[m].iter().zip(&of[0]).map(|(a, b)| ((a - b).abs(), *b)).collect()
        };
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let path = largest(&mut errors(shares).iter().map(|e| e.0));
        let jump = largest(&mut shares[m].windows(2).map(|w| (w[1] - w[0]).abs()));
        let anywhere = errors(random);
        let of_ball = largest(&mut anywhere.iter().map(|e| e.0));
        let of_overlap = largest(&mut anywhere.iter().filter(|e| e.1 >= 0.1).map(|e| e.0 / e.1));
        text.push_str(&format!(
            "| {method} | {:.1} % | {:.1} % | {:.1} % | {:.1} % |\n",
            100.0 * path,
            100.0 * jump,
            100.0 * of_ball,
            100.0 * of_overlap
        ));
    }
    text.push_str(
        "\nThe paper gives 20 % as the largest error of the cube. Which volume that is relative to it does not say; the \
         two columns on the right are the two that suggest themselves.\n",
    );
    text
}
