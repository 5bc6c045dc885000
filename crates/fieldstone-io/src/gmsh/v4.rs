//! Entities, nodes and elements of MSH 4.1. Text and binary files have the same numbers in the same order.

use crate::IoError;

use super::Content;
use super::elements::{Use, use_of};
use super::input::Input;

/// Reads `$Entities` or `$PartitionedEntities` for the physical groups of the volumes.
pub(super) fn read_entities(input: &mut Input, partitioned: bool, content: &mut Content) -> Result<(), IoError> {
    if partitioned {
        input.size()?;
        for _ in 0..input.size_count("ghost entities")? {
            input.integer()?;
            input.integer()?;
        }
    }
    let mut counts = [0; 4];
    for n in &mut counts {
        *n = input.size_count("entities")?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = input.integer()?;
            if partitioned {
                input.integer()?;
                input.integer()?;
                for _ in 0..input.size_count("partitions")? {
                    input.integer()?;
                }
            }
            // A point's coordinates, or the box around anything else.
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                input.real()?;
            }
            let mut groups = Vec::new();
            for _ in 0..input.size_count("physical groups")? {
                groups.push(input.integer()?.abs());
            }
            if dimension > 0 {
                for _ in 0..input.size_count("bounding entities")? {
                    input.integer()?;
                }
            }
            if dimension == 3 {
                groups.sort_unstable();
                groups.dedup();
                content.groups_of_entity.insert(tag, groups);
            }
        }
    }
    Ok(())
}

pub(super) fn read_nodes(input: &mut Input, content: &mut Content) -> Result<(), IoError> {
    let blocks = input.size_count("node blocks")?;
    let total = input.size_count("nodes")?;
    input.size()?;
    input.size()?;
    let before = content.points.len();
    let mut tags = Vec::new();
    for _ in 0..blocks {
        let dimension = input.integer()?;
        input.integer()?;
        let parametric = input.integer()? != 0;
        let count = input.size_count("nodes of a block")?;
        tags.clear();
        for _ in 0..count {
            tags.push(input.size()?);
        }
        for &tag in &tags {
            let at = [input.real()?, input.real()?, input.real()?];
            // Parameters on the curve, surface or volume that the node lies on.
            for _ in 0..if parametric { dimension.clamp(0, 3) } else { 0 } {
                input.real()?;
            }
            content.add_node(input, tag, at)?;
        }
    }
    expect_total(input, content.points.len() - before, total, "nodes")
}

pub(super) fn read_elements(input: &mut Input, content: &mut Content) -> Result<(), IoError> {
    let blocks = input.size_count("element blocks")?;
    let total = input.size_count("elements")?;
    input.size()?;
    input.size()?;
    let mut done = 0;
    for _ in 0..blocks {
        let start = input.start();
        input.integer()?;
        let entity = input.integer()?;
        let kind = input.integer()?;
        let count = input.size_count("elements of a block")?;
        let what = use_of(kind, input, start)?;
        let groups = content.groups_of_entity.get(&entity).cloned().unwrap_or_default();
        let first = content.cells.len() as u32;
        for _ in 0..count {
            let element = input.size()?;
            let mut tags = [0; 8];
            for k in 0..what.nodes() {
                let tag = input.size()?;
                if let Some(t) = tags.get_mut(k) {
                    *t = tag;
                }
            }
            if let Use::Cell(kind) = what {
                content.add_cell(input, kind, element, &tags[..what.nodes()])?;
            }
        }
        for group in groups {
            content.groups.entry(group).or_default().extend(first..content.cells.len() as u32);
        }
        done += count;
    }
    expect_total(input, done, total, "elements")
}

fn expect_total(input: &Input, found: usize, total: usize, what: &str) -> Result<(), IoError> {
    if found == total {
        return Ok(());
    }
    Err(input.error(
        format!("the section announces {total} {what}, but its blocks hold {found}"),
        "the file is damaged; save the mesh again",
    ))
}
