/// Line, from 1, of `key` in the `nth` table of a name; of the table's head where it has no such key. The table ""
/// is what stands before the first head.
pub(super) fn line_of(text: &str, section: &str, nth: usize, key: &str) -> usize {
    let mut seen = 0;
    let mut inside = section.is_empty();
    let mut head = 1;
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if let Some(name) = head_of(line) {
            inside = name == section && seen == nth;
            if name == section {
                seen += 1;
            }
            if inside {
                head = index + 1;
            }
        } else if inside && line.split('=').next().is_some_and(|k| k.trim() == key) {
            return index + 1;
        }
    }
    head
}

/// Name of the table in which a line, from 1, stands; nothing before the first head.
pub(super) fn section_at(text: &str, line: usize) -> Option<&str> {
    text.lines().take(line).filter_map(|line| head_of(line.trim())).last()
}

/// Name of a table's head; a line of an array may begin with a bracket, too.
fn head_of(line: &str) -> Option<&str> {
    let name = line.strip_prefix('[')?.trim_start_matches('[').split(']').next()?.trim();
    let bare = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    (name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(bare)).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::{line_of, section_at};

    #[test]
    fn keys_are_found_in_the_table_that_was_meant() {
        let text = "spacing = 1\n[fluid]\ndelta = 0.1\n[[fill]]\nshape = 1\n[[fill]]\n  shape = 2\n";
        assert_eq!(line_of(text, "", 0, "spacing"), 1);
        assert_eq!(line_of(text, "fluid", 0, "delta"), 3);
        assert_eq!(line_of(text, "fluid", 0, "alpha"), 2);
        assert_eq!(line_of(text, "fill", 1, "shape"), 7);
        assert_eq!(line_of(text, "nowhere", 0, "x"), 1);
    }

    #[test]
    fn rows_of_an_array_are_no_heads() {
        let text = "[[body]]\nmotion = [\n[0, 0.0, 0],\n  [1, 1, 0],\n]\nslip = 1\n[[body]]\nslip = 2\n";
        assert_eq!(line_of(text, "body", 0, "slip"), 6);
        assert_eq!(line_of(text, "body", 1, "slip"), 8);
        assert_eq!((section_at("x = 1\n[a]", 1), section_at(text, 4)), (None, Some("body")));
    }
}
