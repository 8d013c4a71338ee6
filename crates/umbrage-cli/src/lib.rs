//! What `umbrage` shares with the window (`umbrage-view`): options of one name and one meaning, and the files that they
//! are about.
//!
//! The commands themselves are the program's alone.

pub mod camera;
pub mod look;
pub mod method;
pub mod output;
pub mod scene_file;
pub mod shown;
