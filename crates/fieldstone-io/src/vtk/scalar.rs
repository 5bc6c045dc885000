//! Scalar types of VTK files: names, widths, and how numbers are read from bytes and from text.

use crate::Values;

/// Type of an array's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// Reads fixed-width numbers of one type out of bytes.
macro_rules! numbers {
    ($type:ty, $bytes:expr, $big:expr) => {
        $bytes.chunks_exact(size_of::<$type>()).map(|chunk| {
            let mut word = [0; size_of::<$type>()];
            word.copy_from_slice(chunk);
            if $big { <$type>::from_be_bytes(word) } else { <$type>::from_le_bytes(word) }
        })
    };
}

impl Scalar {
    /// The type that an XML file calls `name`.
    pub fn from_xml(name: &str) -> Option<Self> {
        Some(match name {
            "Int8" => Self::I8,
            "UInt8" => Self::U8,
            "Int16" => Self::I16,
            "UInt16" => Self::U16,
            "Int32" => Self::I32,
            "UInt32" => Self::U32,
            "Int64" => Self::I64,
            "UInt64" => Self::U64,
            "Float32" => Self::F32,
            "Float64" => Self::F64,
            _ => return None,
        })
    }

    /// The type that a legacy file calls `name`, in any case.
    ///
    /// `long` is 8 bytes wide, as on every system but Windows; `vtkIdType` is stored in 4.
    pub fn from_legacy(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "char" | "signed_char" | "vtktypeint8" => Self::I8,
            "unsigned_char" | "vtktypeuint8" => Self::U8,
            "short" | "vtktypeint16" => Self::I16,
            "unsigned_short" | "vtktypeuint16" => Self::U16,
            "int" | "vtkidtype" | "vtktypeint32" => Self::I32,
            "unsigned_int" | "vtktypeuint32" => Self::U32,
            "long" | "long_long" | "vtktypeint64" => Self::I64,
            "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => Self::U64,
            "float" => Self::F32,
            "double" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes per number.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The numbers in `bytes`; bytes beyond the last whole number are left out.
    pub fn decode(self, bytes: &[u8], big_endian: bool) -> Values {
        match self {
            Self::U8 => Values::U8(bytes.to_vec()),
            Self::I8 => Values::I64(numbers!(i8, bytes, big_endian).map(i64::from).collect()),
            Self::I16 => Values::I64(numbers!(i16, bytes, big_endian).map(i64::from).collect()),
            Self::U16 => Values::I64(numbers!(u16, bytes, big_endian).map(i64::from).collect()),
            Self::I32 => Values::I64(numbers!(i32, bytes, big_endian).map(i64::from).collect()),
            Self::U32 => Values::I64(numbers!(u32, bytes, big_endian).map(i64::from).collect()),
            Self::I64 => Values::I64(numbers!(i64, bytes, big_endian).collect()),
            Self::U64 => unsigned(numbers!(u64, bytes, big_endian).collect()),
            Self::F32 => Values::F32(numbers!(f32, bytes, big_endian).collect()),
            Self::F64 => Values::F64(numbers!(f64, bytes, big_endian).collect()),
        }
    }

    /// Numbers written as text; at the first word that is no number of this type, its index and itself.
    pub fn parse<'a>(self, words: impl Iterator<Item = &'a [u8]>) -> Result<Values, (usize, String)> {
        fn all<'a, T>(
            words: impl Iterator<Item = &'a [u8]>,
            one: impl Fn(&'a [u8]) -> Option<T>,
        ) -> Result<Vec<T>, (usize, String)> {
            words.enumerate().map(|(k, w)| one(w).ok_or_else(|| (k, word(w)))).collect()
        }
        match self {
            Self::F64 => all(words, |w| fast_float2::parse::<f64, _>(w).ok()).map(Values::F64),
            Self::F32 => all(words, |w| fast_float2::parse::<f32, _>(w).ok()).map(Values::F32),
            Self::U8 => all(words, integer::<u8>).map(Values::U8),
            Self::U64 => all(words, integer::<u64>).map(unsigned),
            // Narrow types are not checked for their range: writers disagree on the sign of `char`.
            _ => all(words, integer::<i64>).map(Values::I64),
        }
    }

    /// An array without numbers.
    pub fn empty(self) -> Values {
        self.decode(&[], false)
    }
}

fn integer<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The word as an error message shows it.
pub(super) fn word(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(40)]).into_owned()
}

/// 64-bit unsigned numbers keep their value where they fit, or become floats: an id of 2⁶⁴ − 1 (VTK's "none")
/// must not make the file unreadable.
fn unsigned(numbers: Vec<u64>) -> Values {
    if numbers.iter().all(|&x| i64::try_from(x).is_ok()) {
        Values::I64(numbers.into_iter().map(|x| x as i64).collect())
    } else {
        Values::F64(numbers.into_iter().map(|x| x as f64).collect())
    }
}

/// The numbers as integers; `None` where they are floats, apart from whole ones below 2⁵³.
pub(super) fn whole_numbers(values: &Values) -> Option<Vec<i64>> {
    fn whole(x: f64) -> Option<i64> {
        (x.trunc() == x && x.abs() < 9007199254740992.0).then_some(x as i64)
    }
    match values {
        Values::I64(v) => Some(v.clone()),
        Values::U8(v) => Some(v.iter().map(|&x| x.into()).collect()),
        Values::F32(v) => v.iter().map(|&x| whole(x.into())).collect(),
        Values::F64(v) => v.iter().map(|&x| whole(x)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn big_and_little_endian_bytes_give_the_same_numbers() {
        let big = Scalar::I32.decode(&[0, 0, 1, 2, 255, 255, 255, 254], true);
        assert_eq!(big, Values::I64(vec![258, -2]));
        assert_eq!(Scalar::I32.decode(&[2, 1, 0, 0, 254, 255, 255, 255], false), big);
    }

    #[test]
    fn an_id_beyond_the_signed_range_becomes_a_float_and_not_minus_one() {
        assert_eq!(Scalar::U64.decode(&[255; 8], false), Values::F64(vec![18446744073709551615.0]));
    }

    #[test]
    fn text_numbers_accept_nan_and_infinity_and_name_the_first_wrong_word() {
        let parse = |s: &'static str| Scalar::F64.parse(s.split(' ').map(str::as_bytes));
        let Ok(Values::F64(v)) = parse("1e-3 nan -inf") else { panic!("floats") };
        assert!(v[0] == 1e-3 && v[1].is_nan() && v[2] == f64::NEG_INFINITY);
        assert_eq!(parse("1 2 three"), Err((2, "three".into())));
    }

    #[test]
    fn only_whole_floats_count_as_integers() {
        assert_eq!(whole_numbers(&Values::F64(vec![1.0, -3.0])), Some(vec![1, -3]));
        assert_eq!(whole_numbers(&Values::F64(vec![1.5])), None);
        assert_eq!(whole_numbers(&Values::F32(vec![f32::NAN])), None);
    }
}
