//! Accessors: numbers of a buffer, strided, sparse, normalized, of any component type.
//!
//! An accessor checks once that all its elements lie in its buffer and then reads them where they lie, so that it
//! allocates nothing, whatever count a file states. Every component type fits an `f64` exactly; normalized integers
//! follow glTF 2.0, section 3.6.2.2.

use super::document::{Document, List, slice};
use super::item::Item;
use crate::FormatError;

/// Type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: usize) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the beginning of `bytes`, and the number that normalization maps to 1.
    fn read(self, bytes: &[u8]) -> (f64, f64) {
        match (self, bytes) {
            (Self::I8, &[a, ..]) => (f64::from(a as i8), 127.0),
            (Self::U8, &[a, ..]) => (f64::from(a), 255.0),
            (Self::I16, &[a, b, ..]) => (f64::from(i16::from_le_bytes([a, b])), 32_767.0),
            (Self::U16, &[a, b, ..]) => (f64::from(u16::from_le_bytes([a, b])), 65_535.0),
            (Self::U32, &[a, b, c, d, ..]) => (f64::from(u32::from_le_bytes([a, b, c, d])), f64::from(u32::MAX)),
            (Self::F32, &[a, b, c, d, ..]) => (f64::from(f32::from_le_bytes([a, b, c, d])), 1.0),
            _ => unreachable!("an element of {self:?} with {} bytes passed the bounds check", bytes.len()),
        }
    }
}

/// Elements at equal distances in a buffer, all of them in it.
#[derive(Clone, Copy, Debug)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Strided<'a> {
    fn open(
        document: &'a Document,
        holder: &Item<'_>,
        view: usize,
        (count, size): (usize, usize),
    ) -> Result<Self, FormatError> {
        let (all, stride) = document.view(view, &holder.place)?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(holder.bad("bufferView", format!("has byteStride {stride}, less than an element's {size}")));
        }
        let offset = holder.whole("byteOffset")?.unwrap_or(0);
        let length = match count {
            0 => Some(0),
            _ => stride.checked_mul(count - 1).and_then(|last| last.checked_add(size)),
        };
        let bytes = slice(all, offset, length.unwrap_or(usize::MAX)).map_err(|end| FormatError::BeyondEnd {
            file: holder.file.to_owned(),
            place: holder.place.clone(),
            end,
            length: all.len() as u64,
        })?;
        Ok(Self { bytes, stride })
    }

    fn element(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..]
    }
}

/// Elements that replace others.
#[derive(Clone, Debug)]
struct Sparse<'a> {
    count: usize,
    /// Which, in strictly increasing order.
    indices: Strided<'a>,
    index_type: Component,
    values: Strided<'a>,
}

impl<'a> Sparse<'a> {
    fn open(document: &'a Document, sparse: &Item<'_>, of: usize, size: usize) -> Result<Self, FormatError> {
        let count = sparse.required_whole("count")?;
        let missing = |key| sparse.bad(key, "is missing");
        let indices = sparse.child("indices")?.ok_or_else(|| missing("indices"))?;
        let values = sparse.child("values")?.ok_or_else(|| missing("values"))?;
        let index_type = component(&indices)?;
        if !matches!(index_type, Component::U8 | Component::U16 | Component::U32) {
            return Err(indices.bad("componentType", "should be an unsigned integer"));
        }
        let index_view = indices.required_whole("bufferView")?;
        let value_view = values.required_whole("bufferView")?;
        let opened = Self {
            count,
            indices: Strided::open(document, &indices, index_view, (count, index_type.bytes()))?,
            index_type,
            values: Strided::open(document, &values, value_view, (count, size))?,
        };
        let mut next = 0;
        for i in 0..count {
            let index = opened.index(i);
            if index < next || index >= of {
                return Err(indices.bad("bufferView", format!("index {index} is out of order or not below {of}")));
            }
            next = index + 1;
        }
        Ok(opened)
    }

    fn index(&self, i: usize) -> usize {
        self.index_type.read(self.indices.element(i)).0 as usize
    }

    /// The bytes that replace element `wanted`.
    fn find(&self, wanted: usize) -> Option<&'a [u8]> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            if self.index(middle) < wanted { low = middle + 1 } else { high = middle }
        }
        (low < self.count && self.index(low) == wanted).then(|| self.values.element(low))
    }
}

/// An accessor whose every element can be read.
#[derive(Clone, Debug)]
pub(super) struct Accessor<'a> {
    /// For messages: what it is used for, and its number.
    pub(super) place: String,
    /// Number of elements.
    pub(super) count: usize,
    component: Component,
    width: usize,
    normalized: bool,
    /// Absent: all zero but for `sparse`.
    base: Option<Strided<'a>>,
    sparse: Option<Sparse<'a>>,
}

impl<'a> Accessor<'a> {
    /// Opens accessor `index`, which `user` refers to and needs to have `width` components, in one of `types`.
    pub(super) fn open(
        document: &'a Document,
        index: usize,
        user: &str,
        width: &[usize],
        types: &[Component],
    ) -> Result<Self, FormatError> {
        let mut item = document.item(List::Accessors, index, user)?;
        item.place = format!("{user} (accessor {index})");
        let kind = item.text("type")?.unwrap_or_default();
        let found = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => 0,
        };
        if !width.contains(&found) {
            return Err(item.bad("type", format!("{kind:?} does not suit this use")));
        }
        let component = component(&item)?;
        if !types.contains(&component) {
            return Err(item.bad("componentType", format!("{component:?} does not suit this use")));
        }
        let count = item.required_whole("count")?;
        let size = found * component.bytes();
        let base = match item.whole("bufferView")? {
            Some(view) => Some(Strided::open(document, &item, view, (count, size))?),
            None => None,
        };
        let sparse = match item.child("sparse")? {
            Some(sparse) => Some(Sparse::open(document, &sparse, count, size)?),
            None => None,
        };
        let normalized = item.flag("normalized")? && component != Component::F32;
        Ok(Self { place: item.place, count, component, width: found, normalized, base, sparse })
    }

    /// Number of elements that replace others.
    pub(super) fn sparse_count(&self) -> usize {
        self.sparse.as_ref().map_or(0, |sparse| sparse.count)
    }

    /// Element `index`, which must be below `count`; components that it lacks are `fill`.
    pub(super) fn element<const N: usize>(&self, index: usize, fill: f64) -> [f64; N] {
        assert!(index < self.count, "element {index} of {}, which has {}", self.place, self.count);
        let bytes = self.sparse.as_ref().and_then(|sparse| sparse.find(index));
        let bytes = bytes.or_else(|| self.base.map(|base| base.element(index)));
        let mut element = [fill; N];
        for (i, e) in element.iter_mut().enumerate().take(self.width) {
            *e = match bytes {
                Some(bytes) => {
                    let (number, one) = self.component.read(&bytes[i * self.component.bytes()..]);
                    if self.normalized { (number / one).max(-1.0) } else { number }
                }
                None => 0.0,
            };
        }
        element
    }

    /// Element `index` of an accessor of indices.
    pub(super) fn index(&self, index: usize) -> usize {
        self.element::<1>(index, 0.0)[0] as usize
    }
}

fn component(item: &Item<'_>) -> Result<Component, FormatError> {
    let code = item.required_whole("componentType")?;
    Component::from_code(code).ok_or_else(|| item.bad("componentType", format!("{code} is not a component type")))
}
