//! Nodes and elements of MSH 2.

use crate::IoError;

use super::Content;
use super::elements::{Use, use_of};
use super::input::Input;

pub(super) fn read_nodes(input: &mut Input, content: &mut Content) -> Result<(), IoError> {
    let count = read_count(input, "nodes")?;
    for _ in 0..count {
        let tag = input.integer()?;
        let at = [input.real()?, input.real()?, input.real()?];
        content.add_node(input, tag, at)?;
    }
    Ok(())
}

/// The count at a section's start, which is text in binary files too.
fn read_count(input: &mut Input, what: &str) -> Result<usize, IoError> {
    let binary = input.set_text();
    let count = input.count(what)?;
    input.end_line();
    input.restore(binary);
    Ok(count)
}

pub(super) fn read_elements(input: &mut Input, content: &mut Content) -> Result<(), IoError> {
    let count = read_count(input, "elements")?;
    let mut last = None;
    let mut done = 0;
    while done < count {
        let start = input.start();
        // In text each element states its type and tags; in binary, a head states them for several.
        let mut element = if input.is_binary() { 0 } else { input.integer()? };
        let kind = input.integer()?;
        let followers = if input.is_binary() { input.count("elements of a block")? } else { 1 };
        let tag_count = input.count("tags")?;
        let what = use_of(kind, input, start)?;
        if followers == 0 || followers > count - done {
            return Err(input.error_at(
                start,
                format!("a block announces {followers} elements, but {} of {count} are left", count - done),
                "the file is damaged; save the mesh again",
            ));
        }
        for _ in 0..followers {
            if input.is_binary() {
                element = input.integer()?;
            }
            let mut group = 0;
            for k in 0..tag_count {
                let tag = input.integer()?;
                if k == 0 {
                    group = tag;
                }
            }
            let mut tags = [0; 8];
            for k in 0..what.nodes() {
                let tag = input.integer()?;
                if let Some(t) = tags.get_mut(k) {
                    *t = tag;
                }
            }
            if let Use::Cell(kind) = what {
                // An element of several groups is listed once for each, one after the other.
                if last != Some((kind, tags)) {
                    content.add_cell(input, kind, element, &tags[..what.nodes()])?;
                    last = Some((kind, tags));
                }
                if group != 0 {
                    // Negative where the group reverses the orientation, which a volume does not have.
                    content.groups.entry(group.abs()).or_default().push(content.cells.len() as u32 - 1);
                }
            }
        }
        done += followers;
    }
    Ok(())
}
