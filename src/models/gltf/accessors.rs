//! Accessors: typed lists in views (glTF 2.0, section 3.6.2). All ranges are checked in 64 bits before anything is read.

use super::super::fault::{Fault, Faults, Kind};
use super::buffers::Buffers;
use super::json::{Accessor, Document};
use std::cell::Cell;

/// Types of the numbers of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    /// The type of a code.
    pub(super) fn of(code: u32) -> Option<Self> {
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

    /// Bytes of a number.
    pub(super) fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// An index. Only unsigned integers are.
    fn index(self, bytes: &[u8]) -> u32 {
        match self {
            Self::U8 => u32::from(bytes[0]),
            Self::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        }
    }

    /// The numbers of an element; what it has none for is 0.
    fn numbers<const N: usize>(self, element: &[u8], normalized: bool) -> [f64; N] {
        let mut numbers = [0.0; N];
        let size = self.size() as usize;
        for (number, bytes) in numbers.iter_mut().zip(element.chunks_exact(size)) {
            *number = self.number(bytes, normalized);
        }
        numbers
    }

    /// A number, as it is or as a part of the largest.
    #[inline]
    fn number(self, bytes: &[u8], normalized: bool) -> f64 {
        let most = |most: f64| if normalized { most } else { 1.0 };
        let signed = |number: f64, most: f64| if normalized { (number / most).max(-1.0) } else { number };
        match self {
            Self::I8 => signed(f64::from(bytes[0] as i8), 127.0),
            Self::U8 => f64::from(bytes[0]) / most(255.0),
            Self::I16 => signed(f64::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32_767.0),
            Self::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])) / most(65_535.0),
            Self::U32 => {
                f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])) / most(4_294_967_295.0)
            }
            Self::F32 => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        }
    }

    /// Writes a number, or the nearest that there is.
    pub(super) fn write(self, number: f64, into: &mut Vec<u8>) {
        match self {
            Self::I8 => into.push(number as i8 as u8),
            Self::U8 => into.push(number as u8),
            Self::I16 => into.extend((number as i16).to_le_bytes()),
            Self::U16 => into.extend((number as u16).to_le_bytes()),
            Self::U32 => into.extend((number as u32).to_le_bytes()),
            Self::F32 => into.extend((number as f32).to_le_bytes()),
        }
    }
}

/// How many numbers an element has.
pub(super) fn width(kind: &str) -> Option<usize> {
    Some(match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" | "MAT2" => 4,
        "MAT3" => 9,
        "MAT4" => 16,
        _ => return None,
    })
}

/// Elements among bytes.
#[derive(Debug, Clone, Copy)]
struct Run {
    offset: u64,
    stride: u64,
    count: u64,
}

/// Notes all accessors whose bytes are not there.
pub(super) fn check_all(document: &Document, faults: &mut Faults) {
    for (index, accessor) in document.accessors.iter().enumerate() {
        let pointer = format!("/accessors/{index}");
        let (Some(component), Some(width)) = (Component::of(accessor.component_type), width(&accessor.kind)) else {
            let detail = format!("{} of {} is no type of glTF", accessor.kind, accessor.component_type);
            faults.push(Fault::new(pointer, Kind::OutOfRange, detail));
            continue;
        };
        if accessor.count == 0 {
            faults.push(Fault::new(format!("{pointer}/count"), Kind::OutOfRange, "\"count\" must be at least 1"));
        }
        let size = component.size() * width as u64;
        if let Some(view) = accessor.buffer_view {
            let run = check_run(document, faults, &pointer, view, accessor.byte_offset, accessor.count, size);
            if let Some(run) = run
                && run.stride < size
            {
                let detail = format!("the stride of bufferView {view} is below the {size} bytes of an element");
                faults.push(Fault::new(format!("/bufferViews/{view}/byteStride"), Kind::OutOfRange, detail));
            }
        }
        let Some(sparse) = &accessor.sparse else { continue };
        if sparse.count > accessor.count {
            let detail = format!("{} elements replace those of only {}", sparse.count, accessor.count);
            faults.push(Fault::new(format!("{pointer}/sparse/count"), Kind::OutOfRange, detail));
        }
        let Some(of_indices) = Component::of(sparse.indices.component_type).filter(|component| is_index(*component))
        else {
            let detail = "indices are unsigned bytes, shorts or ints";
            faults.push(Fault::new(format!("{pointer}/sparse/indices/componentType"), Kind::OutOfRange, detail));
            continue;
        };
        for (key, view, offset, size) in [
            ("indices", sparse.indices.buffer_view, sparse.indices.byte_offset, of_indices.size()),
            ("values", sparse.values.buffer_view, sparse.values.byte_offset, size),
        ] {
            let pointer = format!("{pointer}/sparse/{key}");
            let strided = document.views.get(view).is_some_and(|view| view.byte_stride.is_some());
            if strided {
                let detail = "only views of vertices may have a stride";
                faults.push(Fault::new(format!("{pointer}/bufferView"), Kind::OutOfRange, detail));
            } else {
                check_run(document, faults, &pointer, view, offset, sparse.count, size);
            }
        }
    }
}

fn is_index(component: Component) -> bool {
    matches!(component, Component::U8 | Component::U16 | Component::U32)
}

/// Where elements are in a view, if it has room for them.
fn check_run(
    document: &Document,
    faults: &mut Faults,
    pointer: &str,
    index: usize,
    offset: u64,
    count: u64,
    size: u64,
) -> Option<Run> {
    let Some(view) = document.views.get(index) else {
        let detail = format!("there is no bufferView {index}");
        faults.push(Fault::new(format!("{pointer}/bufferView"), Kind::UnknownReference, detail));
        return None;
    };
    let stride = view.byte_stride.unwrap_or(size);
    let end = stride.checked_mul(count.saturating_sub(1)).and_then(|end| end.checked_add(size)?.checked_add(offset));
    if end.is_none_or(|end| end > view.byte_length) {
        let needs = end.map_or_else(|| "more than 2^64".to_owned(), |end| (end - offset).to_string());
        let detail = format!("needs {needs} bytes from {offset}, and bufferView {index} has {}", view.byte_length);
        faults.push(Fault::new(format!("{pointer}/count"), Kind::OutOfBounds, detail));
        return None;
    }
    Some(Run { offset, stride, count })
}

impl Buffers<'_> {
    /// All elements of an accessor, of one of some widths; those of smaller ones are filled with zeros.
    pub(super) fn elements<const N: usize>(
        &self,
        document: &Document,
        index: usize,
        widths: &[&str],
    ) -> Result<Vec<[f64; N]>, Fault> {
        let accessor = &document.accessors[index];
        let (component, width) = self.typed(accessor, index, widths)?;
        let normalized = accessor.normalized;
        let is_finite = Cell::new(true);
        let elements: Vec<[f64; N]> = match component {
            // Most are: it is told once, and not for each number.
            Component::F32 => self.list(document, index, width, [0.0; N], |bytes| {
                let mut element = [0.0; N];
                for (number, bytes) in element.iter_mut().zip(bytes.as_chunks().0) {
                    *number = f64::from(f32::from_le_bytes(*bytes));
                }
                is_finite.set(is_finite.get() & element.iter().all(|number| number.is_finite()));
                element
            })?,
            other => self.list(document, index, width, [0.0; N], |bytes| other.numbers(bytes, normalized))?,
        };
        if !is_finite.get()
            && let Some(at) = elements.iter().position(|element| element.iter().any(|number| !number.is_finite()))
        {
            let wrong = elements[at].iter().find(|number| !number.is_finite()).copied().unwrap_or_default();
            let detail = format!("element {at} is {wrong}: numbers must be finite");
            return Err(Fault::new(format!("/accessors/{index}"), Kind::OutOfRange, detail));
        }
        Ok(elements)
    }

    /// All elements as indices.
    pub(super) fn indices(&self, document: &Document, index: usize) -> Result<Vec<u32>, Fault> {
        let accessor = &document.accessors[index];
        let (component, _) = self.typed(accessor, index, &["SCALAR"])?;
        if !is_index(component) {
            let detail = "indices are unsigned bytes, shorts or ints";
            return Err(Fault::new(format!("/accessors/{index}/componentType"), Kind::OutOfRange, detail));
        }
        match component {
            Component::U32 => self.list(document, index, 1, 0, |bytes| Component::U32.index(bytes)),
            other => self.list(document, index, 1, 0, |bytes| other.index(bytes)),
        }
    }

    /// All elements as indices, three by three; one or two at the end are left out.
    pub(super) fn triples(&self, document: &Document, index: usize) -> Result<Vec<[u32; 3]>, Fault> {
        let accessor = &document.accessors[index];
        let packed = accessor.buffer_view.filter(|view| {
            let is_strided = document.views[*view].byte_stride.is_some();
            !is_strided && accessor.sparse.is_none() && !self.from_draco.contains_key(&index)
        });
        match (packed, Component::of(accessor.component_type)) {
            // Most are: read at once, without a list of all indices.
            (Some(view), Some(component @ (Component::U16 | Component::U32))) if accessor.kind == "SCALAR" => {
                let (size, count) = (component.size(), accessor.count / 3);
                self.budget.take(count, size_of::<[u32; 3]>())?;
                let run = Run { offset: accessor.byte_offset, stride: 3 * size, count };
                let at = |bytes: &[u8], corner: usize| component.index(&bytes[corner * size as usize..]);
                self.run(view, run, 3 * size, |bytes| [0, 1, 2].map(|corner| at(bytes, corner)))
            }
            _ => {
                let indices = self.indices(document, index)?;
                self.budget.take(indices.len() as u64 / 3, size_of::<[u32; 3]>())?;
                Ok(indices.as_chunks().0.to_vec())
            }
        }
    }

    /// All elements of an accessor of a known type, as they are read of their bytes; `nothing` where it names none.
    fn list<T: Copy>(
        &self,
        document: &Document,
        index: usize,
        width: usize,
        nothing: T,
        read: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, Fault> {
        let accessor = &document.accessors[index];
        self.budget.take(accessor.count, size_of::<T>())?;
        let component = Component::of(accessor.component_type).map_or(0, Component::size);
        let size = component * width as u64;
        let mut elements = match (self.from_draco.get(&index), accessor.buffer_view) {
            (Some(bytes), _) => {
                let run = Run { offset: 0, stride: size, count: accessor.count };
                run.elements(bytes, size, &read).ok_or_else(|| ends_early(format!("/accessors/{index}")))?
            }
            (None, Some(view)) => {
                let stride = document.views[view].byte_stride.unwrap_or(size);
                self.run(view, Run { offset: accessor.byte_offset, stride, count: accessor.count }, size, &read)?
            }
            (None, None) => vec![nothing; accessor.count as usize],
        };
        if let Some(sparse) = &accessor.sparse {
            let places = self.sparse_places(document, accessor, index)?;
            let run = Run { offset: sparse.values.byte_offset, stride: size, count: sparse.count };
            let values = self.run(sparse.values.buffer_view, run, size, &read)?;
            places.into_iter().zip(values).for_each(|(place, value)| elements[place as usize] = value);
        }
        Ok(elements)
    }

    fn typed(&self, accessor: &Accessor, index: usize, widths: &[&str]) -> Result<(Component, usize), Fault> {
        let typed = Component::of(accessor.component_type).zip(width(&accessor.kind));
        typed.filter(|_| widths.contains(&accessor.kind.as_str())).ok_or_else(|| {
            let detail = format!("is {}, and must be {}", accessor.kind, widths.join(" or "));
            Fault::new(format!("/accessors/{index}/type"), Kind::WrongType, detail)
        })
    }

    /// The places of sparse elements: they rise, and are in range.
    fn sparse_places(&self, document: &Document, accessor: &Accessor, index: usize) -> Result<Vec<u32>, Fault> {
        let Some(sparse) = &accessor.sparse else { return Ok(Vec::new()) };
        let wrong = |detail: String| Fault::new(format!("/accessors/{index}/sparse/indices"), Kind::OutOfRange, detail);
        let component = Component::of(sparse.indices.component_type).filter(|component| is_index(*component));
        let component = component.ok_or_else(|| wrong("indices are unsigned".into()))?;
        let view = sparse.indices.buffer_view;
        let stride = document.views[view].byte_stride.unwrap_or(component.size());
        let run = Run { offset: sparse.indices.byte_offset, stride, count: sparse.count };
        self.budget.take(sparse.count, 4)?;
        let places = self.run(view, run, component.size(), |bytes| component.index(bytes))?;
        if let Some(at) = places.windows(2).position(|pair| pair[0] >= pair[1]) {
            return Err(wrong(format!("the indices do not rise after the one at {at}")));
        }
        match places.last() {
            Some(last) if u64::from(*last) >= accessor.count => {
                Err(wrong(format!("the index {last} is not below the count of {}", accessor.count)))
            }
            _ => Ok(places),
        }
    }

    fn run<T>(&self, view: usize, run: Run, size: u64, read: impl Fn(&[u8]) -> T) -> Result<Vec<T>, Fault> {
        let elements = run.elements(self.view(view)?, size, read);
        elements.ok_or_else(|| ends_early(format!("/bufferViews/{view}")))
    }
}

fn ends_early(pointer: String) -> Fault {
    Fault::new(pointer, Kind::OutOfBounds, "the bytes end before the elements do")
}

impl Run {
    /// The elements of so many bytes, if all are there.
    fn elements<T>(self, bytes: &[u8], size: u64, read: impl Fn(&[u8]) -> T) -> Option<Vec<T>> {
        let Some(last) = self.count.checked_sub(1) else { return Some(Vec::new()) };
        let end = self.stride.checked_mul(last).and_then(|end| end.checked_add(self.offset)?.checked_add(size));
        if end.is_none_or(|end| end > bytes.len() as u64) {
            return None;
        }
        let (offset, stride, size) = (self.offset as usize, self.stride as usize, size as usize);
        let at = |i: usize| read(&bytes[offset + i * stride..][..size]);
        Some((0..self.count as usize).map(at).collect())
    }
}
