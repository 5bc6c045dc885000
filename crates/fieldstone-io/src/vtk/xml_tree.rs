//! The XML part of a VTK file as a tree, with the appended data cut off.

use std::borrow::Cow;

use quick_xml::escape::unescape;
use quick_xml::events::{BytesStart, Event};

use super::fault::{Fault, Parsed, damaged};
use crate::Position;

/// Deeper nesting than any VTK file has.
const DEPTH: usize = 64;

/// An element: attributes, text and children.
#[derive(Debug)]
pub(super) struct Element<'a> {
    pub name: String,
    attributes: Vec<(String, String)>,
    pub children: Vec<Element<'a>>,
    /// Text in front of and between the children.
    pub text: Cow<'a, str>,
    /// Byte where the element's start tag ends.
    pub at: u64,
}

impl<'a> Element<'a> {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    pub fn child(&self, name: &str) -> Option<&Element<'a>> {
        self.children.iter().find(|c| c.name == name)
    }

    pub fn all<'b>(&'b self, name: &'b str) -> impl Iterator<Item = &'b Element<'a>> {
        self.children.iter().filter(move |c| c.name == name)
    }

    pub fn position(&self) -> Position {
        Position::Byte(self.at)
    }

    pub fn fault(&self, found: impl Into<String>, remedy: &'static str) -> Fault {
        Fault::new(self.position(), found, remedy)
    }

    /// A count in an attribute; `default` where it is missing.
    pub fn count(&self, name: &str, default: usize) -> Parsed<usize> {
        match self.attribute(name) {
            None => Ok(default),
            Some(text) => text.trim().parse().map_err(|_| {
                self.fault(format!("{name}=\"{text}\" in <{}> is no count", self.name), "write a whole number there")
            }),
        }
    }

    fn open(tag: &BytesStart<'_>, at: u64) -> Parsed<Self> {
        let position = Position::Byte(at);
        let mut attributes = Vec::new();
        for attribute in tag.attributes() {
            let attribute = attribute.map_err(damaged(position))?;
            let value = unescape(&attribute.value).map_err(damaged(position))?;
            attributes.push((attribute.key.as_ref().to_owned(), value.into_owned()));
        }
        Ok(Self { name: tag.name().as_ref().to_owned(), attributes, children: Vec::new(), text: Cow::Borrowed(""), at })
    }

    fn add_text(&mut self, text: Cow<'a, str>) {
        if self.text.trim_ascii().is_empty() {
            self.text = text;
        } else if !text.trim_ascii().is_empty() {
            self.text.to_mut().push_str(&text);
        }
    }
}

/// The block of appended data at the end of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Appended<'a> {
    /// What follows the underscore: offsets count from here.
    pub bytes: &'a [u8],
    pub base64: bool,
    /// Byte of the file where `bytes` starts.
    pub at: u64,
}

/// Splits a file into its tree and its appended data.
///
/// Raw appended data are arbitrary bytes, in which an XML parser would see tags: they are cut off unparsed.
pub(super) fn parse(bytes: &[u8]) -> Parsed<(Element<'_>, Option<Appended<'_>>)> {
    let cut = find(bytes, b"<AppendedData");
    let head = &bytes[..cut.unwrap_or(bytes.len())];
    let text = std::str::from_utf8(head).map_err(|e| {
        Fault::new(
            Position::Byte(e.valid_up_to() as u64),
            "the XML part is not UTF-8",
            "save the file in UTF-8, or write it again",
        )
    })?;
    let root = tree(text, cut.is_some())?;
    let appended = cut.map(|cut| appended(bytes, cut)).transpose()?;
    Ok((root, appended))
}

fn find(bytes: &[u8], pattern: &[u8]) -> Option<usize> {
    let mut at = 0;
    while let Some(step) = bytes[at..].iter().position(|&b| b == pattern[0]) {
        at += step;
        if bytes[at..].starts_with(pattern) {
            return Some(at);
        }
        at += 1;
    }
    None
}

fn appended(bytes: &[u8], cut: usize) -> Parsed<Appended<'_>> {
    let fault = |found: &str| Fault::damaged(Position::Byte(cut as u64), found);
    let tag_end = cut + find(&bytes[cut..], b">").ok_or_else(|| fault("<AppendedData> is not closed"))?;
    let tag = String::from_utf8_lossy(&bytes[cut..tag_end]);
    let base64 = match tag.split_once("encoding").map(|(_, rest)| rest.trim_start_matches([' ', '=', '"', '\''])) {
        Some(rest) if rest.starts_with("raw") => false,
        Some(rest) if rest.starts_with("base64") => true,
        None => true,
        Some(_) => {
            return Err(Fault::new(
                Position::Byte(cut as u64),
                format!("unknown encoding in {tag}>"),
                "raw and base64 are readable",
            ));
        }
    };
    let body = &bytes[tag_end + 1..];
    let skipped = body.iter().take_while(|b| b.is_ascii_whitespace()).count();
    if body.get(skipped) != Some(&b'_') {
        return Err(fault("appended data do not start with an underscore"));
    }
    let start = tag_end + 1 + skipped + 1;
    Ok(Appended { bytes: &bytes[start..], base64, at: start as u64 })
}

fn tree(text: &str, cut: bool) -> Parsed<Element<'_>> {
    let mut reader = quick_xml::Reader::from_str(text);
    // A stray & in a text that holds numbers only will be reported as what it is: no number.
    reader.config_mut().allow_dangling_amp = true;
    let mut open: Vec<Element<'_>> = Vec::new();
    let mut root = None;
    loop {
        let event =
            reader.read_event().map_err(|e| Fault::damaged(Position::Byte(reader.error_position()), e.to_string()))?;
        let at = reader.buffer_position();
        let mut closed = None;
        match event {
            Event::Start(tag) => {
                if open.len() == DEPTH {
                    return Err(Fault::damaged(Position::Byte(at), format!("elements are nested {DEPTH} deep")));
                }
                open.push(Element::open(&tag, at)?);
            }
            Event::Empty(tag) => closed = Some(Element::open(&tag, at)?),
            Event::End(_) => closed = open.pop(),
            Event::Text(text) => {
                if let Some(element) = open.last_mut() {
                    element.add_text(text.into_inner());
                }
            }
            Event::CData(text) => {
                if let Some(element) = open.last_mut() {
                    element.add_text(text.into_inner());
                }
            }
            Event::Eof => break,
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) | Event::GeneralRef(_) => {}
        }
        if let Some(element) = closed {
            match open.last_mut() {
                Some(parent) => parent.children.push(element),
                None => root = root.or(Some(element)),
            }
        }
    }
    // Where the appended data were cut off, the end tags of the elements around them went with them.
    if let (Some(element), false) = (open.last(), cut) {
        return Err(Fault::damaged(element.position(), format!("the file ends inside <{}>", element.name)));
    }
    while let Some(element) = open.pop() {
        match open.last_mut() {
            Some(parent) => parent.children.push(element),
            None => root = root.or(Some(element)),
        }
    }
    root.ok_or_else(|| Fault::damaged(Position::File, "there is no XML element"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn raw_appended_bytes_that_look_like_tags_are_not_parsed() {
        let file = b"<VTKFile a='1'><B x=\"&quot;y\"/><AppendedData encoding=\"raw\">\n _</B>\xff\x00<&</AppendedData></VTKFile>";
        let (root, appended) = parse(file).unwrap();
        assert_eq!(root.attribute("a"), Some("1"));
        assert_eq!(root.child("B").unwrap().attribute("x"), Some("\"y"));
        assert!(appended.unwrap().bytes.starts_with(b"</B>\xff\x00<&"));
    }

    #[test]
    fn text_before_child_elements_is_kept_apart_from_their_text() {
        let (root, _) = parse(b"<D> 1 2 <K>junk</K> </D>").unwrap();
        assert_eq!(root.text.trim(), "1 2");
    }

    #[test]
    fn a_file_cut_inside_an_element_and_endless_nesting_are_errors() {
        assert!(parse(b"<A><B>1 2").unwrap_err().found.contains("ends inside <B>"));
        let deep = "<a>".repeat(100_000);
        assert!(parse(deep.as_bytes()).unwrap_err().found.contains("nested"));
    }
}
