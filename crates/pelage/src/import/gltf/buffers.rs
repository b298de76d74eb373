//! The bytes of a glTF file: container, buffers, views and accessors, every offset checked.

use std::cell::Cell;
use std::path::Path;

use gltf::json;
use json::Index;
use json::accessor::{Accessor, ComponentType, Type};
use json::validation::Checked;

use super::super::{Fault, Files, ImportError, Place};

/// The parsed JSON and the bytes that it refers to.
pub(super) struct Document<'a> {
    pub(super) path: &'a Path,
    pub(super) files: &'a Files,
    pub(super) root: json::Root,
    buffers: Vec<Vec<u8>>,
    /// How many numbers were read from accessors so far.
    numbers: Cell<u64>,
}

impl<'a> Document<'a> {
    /// Opens a `.gltf` or `.glb` file and all of its buffers.
    pub(super) fn open(path: &'a Path, files: &'a Files) -> Result<Self, ImportError> {
        let bytes = files.read(path).map_err(|fault| fault.at(path, Place::File))?;
        let (text, mut blob) = parts(&bytes, path)?;
        let root: json::Root = json::deserialize::from_slice(text).map_err(|e| {
            let message = e.to_string();
            // The line is told as the place.
            let reason = message.split(" at line ").next().unwrap_or_default();
            Fault::Syntax(format!("the JSON cannot be read: {reason}")).at(path, Place::Line(e.line()))
        })?;
        let mut buffers = Vec::with_capacity(root.buffers.len());
        let mut total = 0;
        for (i, buffer) in root.buffers.iter().enumerate() {
            let at = |fault: Fault| fault.at(path, Place::Field(format!("buffers[{i}]")));
            let bytes = match &buffer.uri {
                Some(uri) => fetch(uri, files).map_err(at)?,
                None => blob.take().map(<[u8]>::to_vec).ok_or_else(|| {
                    at(Fault::Syntax("has no `uri`, and the file has no binary chunk for it".into()))
                })?,
            };
            if (bytes.len() as u64) < buffer.byte_length.0 {
                let (found, claimed) = (bytes.len(), buffer.byte_length.0);
                return Err(at(Fault::Syntax(format!("holds {found} bytes of the {claimed} it claims"))));
            }
            total += bytes.len() as u64;
            let limit = files.limits.file_bytes;
            if total > limit {
                return Err(at(Fault::Limit { what: "bytes of all buffers", found: total, limit }));
            }
            buffers.push(bytes);
        }
        Ok(Self { path, files, root, buffers, numbers: Cell::new(0) })
    }

    /// An error in a field of the JSON.
    pub(super) fn fault(&self, field: impl Into<String>, fault: Fault) -> ImportError {
        fault.at(self.path, Place::Field(field.into()))
    }

    /// The entry of a list that `index` names, which `field` holds.
    pub(super) fn get<'b, T>(
        &self,
        list: &'b [T],
        index: Index<T>,
        what: &'static str,
        field: &str,
    ) -> Result<&'b T, ImportError> {
        let index = index.value();
        let missing = || Fault::Index { what, index: index as i64, count: list.len() };
        list.get(index).ok_or_else(|| self.fault(field, missing()))
    }

    /// The bytes of a buffer view, and its stride if it has one.
    pub(super) fn view(
        &self,
        index: Index<json::buffer::View>,
    ) -> Result<(&[u8], Option<usize>), ImportError> {
        let field = format!("bufferViews[{}]", index.value());
        let view = self.get(&self.root.buffer_views, index, "buffer view", "bufferView")?;
        let buffer = self.buffers.get(view.buffer.value()).ok_or_else(|| {
            let (index, count) = (view.buffer.value() as i64, self.buffers.len());
            self.fault(field.as_str(), Fault::Index { what: "buffer", index, count })
        })?;
        let start = view.byte_offset.map_or(0, |o| o.0);
        let bytes = start
            .checked_add(view.byte_length.0)
            .and_then(|end| buffer.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?))
            .ok_or_else(|| {
                self.fault(field.as_str(), Fault::Syntax("reaches beyond the end of its buffer".into()))
            })?;
        Ok((bytes, view.byte_stride.map(|s| s.0)))
    }

    /// The elements of an accessor with `N` components, as floats; integers are scaled where it says so.
    pub(super) fn floats<const N: usize>(
        &self,
        index: Index<Accessor>,
    ) -> Result<Vec<[f32; N]>, ImportError> {
        self.elements(index, |bytes, component, normalized| {
            std::array::from_fn(|i| {
                let value = decode(bytes, i, component);
                (if normalized { normalize(value, component) } else { value }) as f32
            })
        })
    }

    /// The elements of an accessor with `N` unsigned components.
    pub(super) fn unsigned<const N: usize>(
        &self,
        index: Index<Accessor>,
    ) -> Result<Vec<[u32; N]>, ImportError> {
        self.elements(index, |bytes, component, _| {
            std::array::from_fn(|i| decode(bytes, i, component) as u32)
        })
    }

    fn elements<const N: usize, T: Copy>(
        &self,
        index: Index<Accessor>,
        read: impl Fn(&[u8], ComponentType, bool) -> [T; N],
    ) -> Result<Vec<[T; N]>, ImportError> {
        let field = format!("accessors[{}]", index.value());
        let at = |fault: Fault| self.fault(field.as_str(), fault);
        let accessor = self.get(&self.root.accessors, index, "accessor", "accessor")?;
        let (Checked::Valid(component), Checked::Valid(shape)) = (accessor.component_type, accessor.type_)
        else {
            return Err(at(Fault::Syntax("has an unknown component or element type".into())));
        };
        let component = component.0;
        if components(shape) != N {
            return Err(at(Fault::Syntax(format!(
                "has {} components where {N} are needed",
                components(shape)
            ))));
        }
        // Counted over all accessors, and before anything is allocated: one without a buffer view may claim any
        // number of zeros, and any number of primitives may name it.
        let limit = self.files.limits.numbers;
        let found = self.numbers.get().saturating_add(accessor.count.0.saturating_mul(N as u64));
        if found > limit {
            return Err(at(Fault::Limit { what: "numbers in accessors", found, limit }));
        }
        self.numbers.set(found);
        let count = accessor.count.0 as usize;
        let size = N * bytes_of(component);
        let mut elements = match accessor.buffer_view {
            None => vec![read(&[0; 64][..size], component, false); count],
            Some(view) => {
                let (bytes, stride) = self.view(view)?;
                let places = strided(bytes, accessor.byte_offset.map_or(0, |o| o.0), stride, size, count);
                let places = places.ok_or_else(|| at(beyond()))?;
                places.map(|element| read(element, component, accessor.normalized)).collect()
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let Checked::Valid(index_type) = sparse.indices.component_type else {
                return Err(at(Fault::Syntax("has sparse indices of an unknown type".into())));
            };
            let index_size = bytes_of(index_type.0);
            let changed = usize::try_from(sparse.count.0).ok().filter(|&c| c <= count);
            let changed =
                changed.ok_or_else(|| at(Fault::Syntax("changes more elements than it has".into())))?;
            let (bytes, _) = self.view(sparse.indices.buffer_view)?;
            let indices = strided(bytes, sparse.indices.byte_offset.0, None, index_size, changed);
            let (bytes, _) = self.view(sparse.values.buffer_view)?;
            let values = strided(bytes, sparse.values.byte_offset.0, None, size, changed);
            let (Some(indices), Some(values)) = (indices, values) else { return Err(at(beyond())) };
            for (place, value) in indices.zip(values) {
                let place = decode(place, 0, index_type.0) as usize;
                let what = "element of the accessor";
                let missing = Fault::Index { what, index: place as i64, count };
                *elements.get_mut(place).ok_or_else(|| at(missing))? =
                    read(value, component, accessor.normalized);
            }
        }
        Ok(elements)
    }
}

fn beyond() -> Fault {
    Fault::Syntax("reaches beyond the end of its buffer view".into())
}

/// `count` elements of `size` bytes, or `None` where the bytes do not reach.
fn strided(
    bytes: &[u8],
    offset: u64,
    stride: Option<usize>,
    size: usize,
    count: usize,
) -> Option<impl Iterator<Item = &[u8]>> {
    let offset = usize::try_from(offset).ok()?;
    let stride = stride.unwrap_or(size).max(1);
    let length = count.checked_sub(1).map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size))?;
    let bytes = bytes.get(offset..offset.checked_add(length)?)?;
    // The last element may be shorter than a stride.
    Some((0..count).map(move |i| &bytes[i * stride..i * stride + size]))
}

fn components(shape: Type) -> usize {
    match shape {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 | Type::Mat2 => 4,
        Type::Mat3 => 9,
        Type::Mat4 => 16,
    }
}

fn bytes_of(component: ComponentType) -> usize {
    match component {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

/// Component `i` of an element; every type fits in an `f64`.
fn decode(element: &[u8], i: usize, component: ComponentType) -> f64 {
    let byte = |k: usize| element[i * bytes_of(component) + k];
    match component {
        ComponentType::I8 => f64::from(byte(0) as i8),
        ComponentType::U8 => f64::from(byte(0)),
        ComponentType::I16 => f64::from(i16::from_le_bytes([byte(0), byte(1)])),
        ComponentType::U16 => f64::from(u16::from_le_bytes([byte(0), byte(1)])),
        ComponentType::U32 => f64::from(u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)])),
        ComponentType::F32 => f64::from(f32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)])),
    }
}

/// Integers to `[0,1]` or `[−1,1]`. [glTF §3.11]
fn normalize(value: f64, component: ComponentType) -> f64 {
    match component {
        ComponentType::I8 => (value / 127.0).max(-1.0),
        ComponentType::U8 => value / 255.0,
        ComponentType::I16 => (value / 32767.0).max(-1.0),
        ComponentType::U16 => value / 65535.0,
        ComponentType::U32 | ComponentType::F32 => value,
    }
}

/// The JSON of a file, as bytes that need not be text.
pub(crate) fn text(path: &Path, files: &Files) -> Result<Vec<u8>, ImportError> {
    let bytes = files.read(path).map_err(|fault| fault.at(path, Place::File))?;
    Ok(parts(&bytes, path)?.0.to_vec())
}

/// The JSON of a text or binary file, and the binary chunk.
fn parts<'a>(bytes: &'a [u8], path: &Path) -> Result<Chunks<'a>, ImportError> {
    if bytes.starts_with(b"glTF") {
        chunks(bytes).map_err(|(byte, what)| Fault::Syntax(what.into()).at(path, Place::Byte(byte)))
    } else {
        Ok((bytes, None))
    }
}

/// The JSON of a binary glTF, and the binary chunk if it has one.
type Chunks<'a> = (&'a [u8], Option<&'a [u8]>);

/// The chunks of a binary glTF, or the byte at which it goes wrong, and how. [glTF §4]
fn chunks(bytes: &[u8]) -> Result<Chunks<'_>, (usize, &'static str)> {
    let word = |at: usize| {
        bytes
            .get(at..at + 4)
            .and_then(|b| b.try_into().ok())
            .map(u32::from_le_bytes)
            .ok_or((at, "the file ends here"))
    };
    if word(4)? != 2 {
        return Err((4, "only version 2 of binary glTF is supported"));
    }
    if word(8)? as usize > bytes.len() {
        return Err((8, "the file is shorter than its header says"));
    }
    let chunk = |at: usize, kind: &[u8]| {
        let length = word(at)? as usize;
        if bytes.get(at + 4..at + 8) != Some(kind) {
            return Err((at + 4, "this is not the kind of chunk that belongs here"));
        }
        bytes.get(at + 8..at + 8 + length).ok_or((at, "the chunk is longer than the file"))
    };
    let text = chunk(12, b"JSON")?;
    let next = 20 + text.len();
    let blob = if next + 8 <= bytes.len() { Some(chunk(next, b"BIN\0")?) } else { None };
    Ok((text, blob))
}

/// The bytes behind a URI: a `data:` URI or a relative path.
pub(super) fn fetch(uri: &str, files: &Files) -> Result<Vec<u8>, Fault> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (header, payload) =
            data.split_once(',').ok_or_else(|| Fault::Syntax("the data URI has no comma".into()))?;
        if !header.ends_with(";base64") {
            return Ok(percent_decoded(payload));
        }
        return base64(payload).ok_or_else(|| Fault::Syntax("the data URI is not valid base64".into()));
    }
    files.read(&files.resolve(&path_of(uri)?)?)
}

/// The relative path that a URI without scheme names.
pub(super) fn path_of(uri: &str) -> Result<String, Fault> {
    // A colon before any slash ends a scheme, as in `file:` or `C:`.
    if uri.split('/').next().is_some_and(|first| first.contains(':')) {
        return Err(Fault::Outside(uri.chars().take(200).collect()));
    }
    Ok(String::from_utf8_lossy(&percent_decoded(uri)).into_owned())
}

fn percent_decoded(text: &str) -> Vec<u8> {
    let mut decoded = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let escape = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
        match tail.get(..2).filter(|_| first == b'%').and_then(escape) {
            Some(byte) => {
                decoded.push(byte);
                rest = &tail[2..];
            }
            None => {
                decoded.push(first);
                rest = tail;
            }
        }
    }
    decoded
}

/// Standard base64, padded or not. [RFC 4648]
fn base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut decoded = Vec::with_capacity(text.len() * 3 / 4);
    for quad in text.chunks(4) {
        let mut bits = 0_u32;
        for &c in quad {
            let value = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' | b'-' => 62,
                b'/' | b'_' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }
        bits <<= 6 * (4 - quad.len());
        let bytes = bits.to_be_bytes();
        match quad.len() {
            4 => decoded.extend_from_slice(&bytes[1..4]),
            3 => decoded.extend_from_slice(&bytes[1..3]),
            2 => decoded.push(bytes[1]),
            _ => return None,
        }
    }
    Some(decoded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_rfc_4648() {
        for (text, bytes) in [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmE", "fooba")]
        {
            assert_eq!(base64(text).as_deref(), Some(bytes.as_bytes()), "{text}");
        }
        assert_eq!(base64("Z"), None);
        assert_eq!(base64("Zm9*"), None);
    }

    #[test]
    fn uris_to_paths() {
        assert_eq!(path_of("my%20fur/a%2.png").expect("a path"), "my fur/a%2.png");
        assert!(matches!(path_of("file:///etc/passwd"), Err(Fault::Outside(_))));
        assert!(matches!(path_of("C:/x.png"), Err(Fault::Outside(_))));
    }

    #[test]
    fn strided_elements_stay_inside() {
        let bytes = [0, 1, 2, 3, 4, 5, 6];
        let at =
            |stride, count| strided(&bytes, 1, stride, 2, count).map(|e| e.map(|b| b[0]).collect::<Vec<_>>());
        assert_eq!(at(None, 3), Some(vec![1, 3, 5]));
        assert_eq!(at(Some(4), 2), Some(vec![1, 5]));
        assert_eq!(at(Some(4), 3), None);
        assert_eq!(at(None, 0), Some(vec![]));
        assert_eq!(at(Some(usize::MAX), 3), None);
    }
}
