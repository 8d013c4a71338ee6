//! Why a file could not be read or written.
//!
//! Every message names the file, the place in it (node, mesh, primitive, vertex or triangle, accessor), what is wrong
//! there, and how to mend it. Files are named as the caller named them.

use std::io;

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum FormatError {
    /// The operating system refused to read the file.
    #[error("{file}: cannot be read: {source}: check the path and its permissions")]
    Unreadable {
        /// The file.
        file: String,
        /// What the operating system says.
        source: io::Error,
    },
    /// The operating system refused to write the file; what stood there before is untouched.
    #[error("{file}: cannot be written: {source}: check that its folder exists, is writable and has room")]
    Unwritable {
        /// The file.
        file: String,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file has no bytes.
    #[error("{file}: the file is empty: export or copy it again")]
    Empty {
        /// The file.
        file: String,
    },
    /// Neither the beginning of the file nor its name is that of a known format.
    #[error("{file}: {found} is not a format that can be read: {cure}")]
    UnknownFormat {
        /// The file.
        file: String,
        /// What it seems to be.
        found: String,
        /// How to make something of it that can be read.
        cure: &'static str,
    },
    /// The frame of a GLB is broken: its header or its chunks.
    #[error("{file}: not a sound GLB: {what}: export or copy it again")]
    BadContainer {
        /// The file.
        file: String,
        /// What is broken.
        what: String,
    },
    /// The JSON part cannot be parsed.
    #[error("{file}: its JSON is broken: {what}: export or copy it again")]
    BadJson {
        /// The file.
        file: String,
        /// What is wrong, with line and column.
        what: String,
    },
    /// The file is of another version of glTF.
    #[error("{file}: is glTF {version}, and only 2.0 can be read: convert it to glTF 2.0")]
    BadVersion {
        /// The file.
        file: String,
        /// Its version, or the one that it asks for.
        version: String,
    },
    /// The geometry needs an extension that is not supported.
    #[error("{file}: {place}: needs the extension {extension}, which is not supported: {cure}")]
    UnsupportedExtension {
        /// The file.
        file: String,
        /// Where it is needed.
        place: String,
        /// Name of the extension.
        extension: String,
        /// How to get a file without it.
        cure: &'static str,
    },
    /// A property is missing, or is not what glTF says it is.
    #[error("{file}: {place}: {what}: export it again, and run a glTF validator if it persists")]
    BadProperty {
        /// The file.
        file: String,
        /// The object and property.
        place: String,
        /// What is wrong with it.
        what: String,
    },
    /// Something refers to an object that does not exist.
    #[error("{file}: {place}: refers to number {index}, but there are only {count}: export it again")]
    DanglingReference {
        /// The file.
        file: String,
        /// The property that refers.
        place: String,
        /// To which number.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Data reach beyond the end of what holds them.
    #[error(
        "{file}: {place}: reaches to byte {end}, but there are only {length}: the file is cut off or badly exported"
    )]
    BeyondEnd {
        /// The file.
        file: String,
        /// The accessor, bufferView or buffer.
        place: String,
        /// One past the last byte wanted.
        end: u64,
        /// The bytes that there are.
        length: u64,
    },
    /// A buffer's bytes cannot be had.
    #[error("{file}: {place}: {what}: {cure}")]
    BadBuffer {
        /// The file.
        file: String,
        /// The buffer.
        place: String,
        /// What is wrong.
        what: String,
        /// How to mend it.
        cure: &'static str,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("{file}: {place}: refers to vertex {index}, but there are only {count}: export the mesh again")]
    BadIndex {
        /// The file.
        file: String,
        /// Node, mesh, primitive and triangle.
        place: String,
        /// The index that is too large.
        index: u64,
        /// How many vertices there are.
        count: usize,
    },
    /// A coordinate or another number of a vertex is NaN or infinite.
    #[error(
        "{file}: {place}: is {value}, which is not finite: repair the mesh (merge or delete the vertex) and export again"
    )]
    NotFinite {
        /// The file.
        file: String,
        /// Node, mesh, primitive, attribute and vertex.
        place: String,
        /// The value.
        value: String,
    },
    /// A statement or a value of a text, or a part of a binary mesh, is not what its format says it is.
    #[error("{file}: {place}: {what}: {cure}")]
    BadStatement {
        /// The file, which may be one that the scene includes.
        file: String,
        /// The line, or the element of a binary file.
        place: String,
        /// What is wrong.
        what: String,
        /// How to mend it.
        cure: &'static str,
    },
    /// Something is said of a material that the scene has not.
    #[error("{file}: there is no material {name:?}{like}: the scene has {known}")]
    UnknownMaterial {
        /// The file that says it, or the options.
        file: String,
        /// The name.
        name: String,
        /// The most similar name, as part of the message; empty if none is.
        like: String,
        /// The names that there are.
        known: String,
    },
    /// A node is named that the scene has not.
    #[error("{file}: there is no node {name:?}{like}: the scene has {known}")]
    UnknownNode {
        /// Who names it.
        file: String,
        /// The name.
        name: String,
        /// The most similar name, as part of the message; empty if none is.
        like: String,
        /// The names that there are.
        known: String,
    },
    /// No node with polygons is left to be baked.
    #[error("{file}: leave no polygon to be baked: name fewer nodes to skip, or others to bake")]
    NothingChosen {
        /// Who chose.
        file: String,
    },
    /// The nodes are no forest of moderate depth.
    #[error("{file}: {place}: {what}: repair the hierarchy of the scene and export again")]
    BadHierarchy {
        /// The file.
        file: String,
        /// The node.
        place: String,
        /// What is wrong.
        what: String,
    },
    /// A small file that unfolds into far more geometry than it has bytes for.
    #[error(
        "{file}: {place}: the scene would unfold to {wanted} corners, and for a file of its size {limit} are allowed: apply or reduce its instances"
    )]
    TooLarge {
        /// The file.
        file: String,
        /// Where the limit was passed.
        place: String,
        /// Corners so far.
        wanted: u64,
        /// Corners allowed.
        limit: u64,
    },
    /// The file is no baked file.
    #[error("{file}: {place}: has no {what}: this is not a baked file, bake it first")]
    NotBaked {
        /// The file.
        file: String,
        /// The primitive, or the asset.
        place: String,
        /// What is missing.
        what: &'static str,
    },
    /// The exposure that was asked for is no exposure.
    #[error("{file}: the exposure is {exposure}, and must be a finite number above 0")]
    BadExposure {
        /// The file.
        file: String,
        /// The exposure.
        exposure: f64,
    },
    /// The baked mesh breaks a promise: a defect of this program.
    #[error("{file}: was not written: {what}: this is a defect of umbrage, please report it with the scene")]
    BrokenMesh {
        /// The file.
        file: String,
        /// Where, and what is broken.
        what: String,
    },
    /// There is nothing to write.
    #[error("{file}: the baked mesh has no triangles: give the scene surfaces that have an area")]
    NothingToWrite {
        /// The file.
        file: String,
    },
    /// A GLB cannot be longer than 4 GiB.
    #[error(
        "{file}: would have {bytes} bytes, and a GLB has at most 2^32 - 1: bake to a coarser tolerance or in parts"
    )]
    OutputTooLarge {
        /// The file.
        file: String,
        /// Its bytes.
        bytes: u64,
    },
}
