//! Named columns as files store them.

/// Numbers of a [`DataArray`] in the type that the file has.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// 64-bit floats.
    F64(Vec<f64>),
    /// 32-bit floats.
    F32(Vec<f32>),
    /// 64-bit signed integers; narrower ones and unsigned ones that fit are widened when read.
    I64(Vec<i64>),
    /// Bytes.
    U8(Vec<u8>),
}

impl Values {
    /// How many numbers there are.
    pub fn len(&self) -> usize {
        match self {
            Self::F64(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::I64(v) => v.len(),
            Self::U8(v) => v.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The numbers as 64-bit floats; integers above 2⁵³ are rounded.
    pub fn to_f64(&self) -> Vec<f64> {
        match self {
            Self::F64(v) => v.clone(),
            Self::F32(v) => v.iter().map(|&x| x.into()).collect(),
            Self::I64(v) => v.iter().map(|&x| x as f64).collect(),
            Self::U8(v) => v.iter().map(|&x| x.into()).collect(),
        }
    }
}

/// A named column on points or cells of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct DataArray {
    /// Name.
    pub name: String,
    /// Numbers per point or cell.
    pub components: usize,
    /// `components` numbers per point or cell.
    pub values: Values,
}

impl DataArray {
    /// A column of one 64-bit float per point or cell.
    pub fn scalar(name: impl Into<String>, data: Vec<f64>) -> Self {
        Self { name: name.into(), components: 1, values: Values::F64(data) }
    }

    /// A column of several 64-bit floats per point or cell.
    pub fn floats(name: impl Into<String>, components: usize, data: Vec<f64>) -> Self {
        Self { name: name.into(), components, values: Values::F64(data) }
    }

    /// A column of one integer per point or cell.
    pub fn integers(name: impl Into<String>, data: Vec<i64>) -> Self {
        Self { name: name.into(), components: 1, values: Values::I64(data) }
    }
}
