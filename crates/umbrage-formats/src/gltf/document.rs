//! A glTF document: its JSON, its buffers, and the lists that its parts refer to by number.

use std::path::Path;

use serde_json::{Value, json};

use super::buffer::Buffers;
use super::container;
use super::item::Item;
use super::unpack;
use crate::FormatError;
use crate::beside::Folder;

/// An opened `.gltf` or `.glb`.
#[derive(Debug)]
pub(super) struct Document {
    /// The file, as the caller named it.
    pub(super) file: String,
    file_bytes: u64,
    json: Value,
    buffers: Buffers,
}

/// The lists of a glTF that are referred to by number.
#[derive(Clone, Copy, Debug)]
pub(super) enum List {
    Accessors,
    BufferViews,
    Buffers,
    Cameras,
    Images,
    Materials,
    Meshes,
    Nodes,
    Samplers,
    Scenes,
    Textures,
}

impl List {
    fn key_and_noun(self) -> (&'static str, &'static str) {
        match self {
            Self::Accessors => ("accessors", "accessor"),
            Self::BufferViews => ("bufferViews", "bufferView"),
            Self::Buffers => ("buffers", "buffer"),
            Self::Cameras => ("cameras", "camera"),
            Self::Images => ("images", "image"),
            Self::Materials => ("materials", "material"),
            Self::Meshes => ("meshes", "mesh"),
            Self::Nodes => ("nodes", "node"),
            Self::Samplers => ("samplers", "sampler"),
            Self::Scenes => ("scenes", "scene"),
            Self::Textures => ("textures", "texture"),
        }
    }
}

impl Document {
    /// Parses a file's bytes. Buffers and images are looked for in `folder`.
    pub(super) fn parse(path: &Path, bytes: Vec<u8>, folder: Folder) -> Result<Self, FormatError> {
        let file = path.display().to_string();
        let (json, chunk) = if bytes.starts_with(&container::MAGIC) {
            let chunks = container::chunks(&file, &bytes)?;
            let chunk = chunks.binary.map(|chunk| {
                let start = chunk.as_ptr().addr() - bytes.as_ptr().addr();
                start..start + chunk.len()
            });
            (parse_json(&file, chunks.json)?, chunk)
        } else {
            (parse_json(&file, &bytes)?, None)
        };
        check_version(&Item::new(&file, "the asset".into(), json.get("asset").unwrap_or(&Value::Null))?)?;
        let file_bytes = bytes.len() as u64;
        let glb = if chunk.is_some() { bytes } else { Vec::new() };
        let buffers = Buffers::list(&Item::new(&file, "the document".into(), &json)?, folder, glb, chunk)?;
        let mut document = Self { file_bytes, json, buffers, file };
        unpack::unpack(&mut document)?;
        Ok(document)
    }

    /// Whether a buffer has bytes; a fallback of a compression extension has none.
    pub(super) fn has_bytes(&self, buffer: usize) -> bool {
        self.buffers.has_bytes(buffer)
    }

    /// Adds a buffer; its number.
    pub(super) fn add_buffer(&mut self, bytes: Vec<u8>) -> usize {
        self.add(List::Buffers, json!({"byteLength": bytes.len()}));
        self.buffers.add(bytes)
    }

    /// Adds a bufferView; its number.
    pub(super) fn add_view(&mut self, view: Value) -> usize {
        self.add(List::BufferViews, view)
    }

    /// Puts another object in the place of one.
    pub(super) fn replace(&mut self, list: List, index: usize, value: Value) {
        if let Some(old) = self.json.get_mut(list.key_and_noun().0).and_then(|all| all.get_mut(index)) {
            *old = value;
        }
    }

    /// Leads an accessor to a bufferView of its own, and changes properties of it.
    pub(super) fn change_accessor(&mut self, index: usize, view: usize, changes: Value) {
        let accessor = self.json.get_mut("accessors").and_then(|all| all.get_mut(index)).and_then(Value::as_object_mut);
        if let (Some(accessor), Value::Object(changes)) = (accessor, changes) {
            accessor.remove("byteOffset");
            accessor.insert("bufferView".into(), json!(view));
            accessor.extend(changes);
        }
    }

    fn add(&mut self, list: List, value: Value) -> usize {
        match self.json.get_mut(list.key_and_noun().0).and_then(Value::as_array_mut) {
            Some(all) => {
                all.push(value);
                all.len() - 1
            }
            None => {
                self.json[list.key_and_noun().0] = json!([value]);
                0
            }
        }
    }

    /// Bytes of the file and of all buffers loaded so far: what memory may be proportional to.
    pub(super) fn input_bytes(&self) -> u64 {
        self.file_bytes + self.buffers.loaded_bytes()
    }

    /// The whole document.
    pub(super) fn root(&self) -> Result<Item<'_>, FormatError> {
        Item::new(&self.file, "the document".into(), &self.json)
    }

    /// How many objects a list has.
    pub(super) fn count(&self, list: List) -> Result<usize, FormatError> {
        Ok(self.root()?.list(list.key_and_noun().0)?.len())
    }

    /// Object `index` of a list, to which `user` refers.
    pub(super) fn item(&self, list: List, index: usize, user: &str) -> Result<Item<'_>, FormatError> {
        let (key, noun) = list.key_and_noun();
        let all = self.json.get(key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let value = all.get(index).ok_or_else(|| FormatError::DanglingReference {
            file: self.file.clone(),
            place: format!("{user}, {noun}"),
            index,
            count: all.len(),
        })?;
        Item::named(&self.file, format!("{noun} {index}"), value)
    }

    /// The bytes of a bufferView, and its stride if it states one.
    pub(super) fn view(&self, index: usize, user: &str) -> Result<(&[u8], Option<usize>), FormatError> {
        let view = self.item(List::BufferViews, index, user)?;
        let number = view.required_whole("buffer")?;
        let buffer = self.item(List::Buffers, number, &view.place)?;
        Ok((self.section(number, &buffer, &view, user)?, view.whole("byteStride")?))
    }

    /// The bytes that an object with `buffer`, `byteOffset` and `byteLength` means.
    pub(super) fn bytes_of(&self, holder: &Item<'_>) -> Result<&[u8], FormatError> {
        let number = holder.required_whole("buffer")?;
        let buffer = self.item(List::Buffers, number, &holder.place)?;
        self.section(number, &buffer, holder, "compressed")
    }

    fn section(&self, number: usize, buffer: &Item<'_>, holder: &Item<'_>, user: &str) -> Result<&[u8], FormatError> {
        let all = self.buffers.bytes(number, buffer)?;
        let offset = holder.whole("byteOffset")?.unwrap_or(0);
        let length = holder.required_whole("byteLength")?;
        slice(all, offset, length).map_err(|end| FormatError::BeyondEnd {
            file: self.file.clone(),
            place: format!("{} ({user})", holder.place),
            end,
            length: all.len() as u64,
        })
    }

    /// The bytes of an image's file: embedded, or beside the glTF.
    pub(super) fn image(&self, index: usize, user: &str) -> Result<Vec<u8>, FormatError> {
        let image = self.item(List::Images, index, user)?;
        match (image.whole("bufferView")?, image.text("uri")?) {
            (Some(view), _) => Ok(self.view(view, &image.place)?.0.to_vec()),
            (None, Some(uri)) => self.buffers.load(uri, &image),
            (None, None) => Err(image.bad("uri", "is missing, and so is bufferView")),
        }
    }
}

/// `bytes[offset..offset + length]`, or where it would have to end.
pub(super) fn slice(bytes: &[u8], offset: usize, length: usize) -> Result<&[u8], u64> {
    let end = offset.checked_add(length);
    end.and_then(|end| bytes.get(offset..end)).ok_or(end.map_or(u64::MAX, |end| end as u64))
}

fn parse_json(file: &str, bytes: &[u8]) -> Result<Value, FormatError> {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    // The chunk should be padded with blanks, and some exporters pad it like the other one.
    let text = &text[..text.iter().rposition(|&byte| byte != 0 && byte != b' ').map_or(0, |last| last + 1)];
    serde_json::from_slice(text).map_err(|e| FormatError::BadJson { file: file.to_owned(), what: e.to_string() })
}

fn check_version(asset: &Item<'_>) -> Result<(), FormatError> {
    let version = asset.text("version")?.ok_or_else(|| asset.bad("version", "is missing"))?;
    let least = asset.text("minVersion")?.unwrap_or("2.0");
    let found = if version.split('.').next() == Some("2") { least } else { version };
    if found == "2.0" {
        return Ok(());
    }
    Err(FormatError::BadVersion { file: asset.file.to_owned(), version: found.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(json: &str) -> Result<Document, FormatError> {
        Document::parse(Path::new("a.gltf"), json.as_bytes().to_vec(), Folder::default())
    }

    #[test]
    fn versions() {
        assert!(parse(r#"{"asset":{"version":"2.0"}}"#).is_ok());
        assert!(parse("\u{feff}{\"asset\":{\"version\":\"2.1\"}}").is_ok());
        for json in [r#"{"asset":{"version":"1.0"}}"#, r#"{"asset":{"version":"2.0","minVersion":"2.1"}}"#] {
            assert!(matches!(parse(json), Err(FormatError::BadVersion { .. })), "{json}");
        }
        assert!(matches!(parse("{}"), Err(FormatError::BadProperty { .. })));
        assert!(matches!(parse("[1, 2"), Err(FormatError::BadJson { .. })));
    }

    #[test]
    fn a_dangling_reference_names_who_refers() {
        let document = parse(r#"{"asset":{"version":"2.0"},"meshes":[{}]}"#).unwrap();
        let message = document.item(List::Meshes, 4, "node 2").unwrap_err().to_string();
        assert!(message.contains("node 2, mesh: refers to number 4, but there are only 1"), "{message}");
    }

    #[test]
    fn slices_never_overflow() {
        assert_eq!(slice(&[1, 2, 3], 1, 2), Ok([2, 3].as_slice()));
        assert_eq!(slice(&[1, 2, 3], 2, 2), Err(4));
        assert_eq!(slice(&[1, 2, 3], usize::MAX, 2), Err(u64::MAX));
    }
}
