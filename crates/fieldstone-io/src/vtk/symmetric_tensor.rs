//! The order of a symmetric tensor's six components: xx xy xz yy yz zz in memory, VTK's own in files.
//!
//! VTK's filters take six components for XX YY ZZ XY YZ XZ, whatever they are called. Only columns that name their
//! components are put into that order and back: of others nobody knows what they hold.

use crate::Values;

const IN_MEMORY: [&str; 6] = ["xx", "xy", "xz", "yy", "yz", "zz"];

/// Which component of those in memory stands at each place in a file.
const IN_FILE: [usize; 6] = [0, 3, 5, 1, 4, 2];

/// Whether these are the components of a symmetric tensor in the order of memory.
pub(super) fn is_symmetric<S: AsRef<str>>(names: &[S]) -> bool {
    names.iter().map(AsRef::as_ref).eq(IN_MEMORY)
}

/// Whether these are the same in the order of files.
pub(super) fn is_in_file_order<S: AsRef<str>>(names: &[S]) -> bool {
    names.iter().map(AsRef::as_ref).eq(IN_FILE.map(|component| IN_MEMORY[component]))
}

/// Rows of six in the order of files.
pub(super) fn to_file<T: Copy>(rows: &[T; 6]) -> [T; 6] {
    IN_FILE.map(|component| rows[component])
}

/// All values in the order of files.
pub(super) fn values_to_file(values: &Values) -> Values {
    fn all<T: Copy>(values: &[T]) -> Vec<T> {
        values.as_chunks::<6>().0.iter().flat_map(to_file).collect()
    }
    match values {
        Values::F64(v) => Values::F64(all(v)),
        Values::F32(v) => Values::F32(all(v)),
        Values::I64(v) => Values::I64(all(v)),
        Values::U8(v) => Values::U8(all(v)),
    }
}

/// Values of a file in the order of memory.
pub(super) fn values_from_file(mut values: Values) -> Values {
    fn all<T: Copy>(values: &mut [T]) {
        for row in values.as_chunks_mut::<6>().0 {
            let file = *row;
            IN_FILE.iter().zip(file).for_each(|(&component, value)| row[component] = value);
        }
    }
    match &mut values {
        Values::F64(v) => all(v),
        Values::F32(v) => all(v),
        Values::I64(v) => all(v),
        Values::U8(v) => all(v),
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_from_the_order_of_files() {
        let memory = Values::I64((0..12).collect());
        let file = values_to_file(&memory);
        assert_eq!(file, Values::I64(vec![0, 3, 5, 1, 4, 2, 6, 9, 11, 7, 10, 8]));
        assert_eq!(values_from_file(file), memory);
        assert_eq!(to_file(&IN_MEMORY), ["xx", "yy", "zz", "xy", "yz", "xz"]);
    }
}
