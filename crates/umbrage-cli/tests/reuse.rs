//! `umbrage bake --reuse FILE` as a user meets it.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A bake of the Cornell box that takes little time, into a folder of the test's own.
struct Bakes {
    folder: PathBuf,
}

impl Bakes {
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reuse").join(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn bake(&self, output: &str, more: &[&str]) -> Output {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/scenes/cornell.obj");
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbrage"));
        command.arg("bake").arg(scene).arg("-o").arg(self.path(output)).args(["--tolerance", "0.2"]);
        command.args(more).output().unwrap()
    }

    /// A bake that succeeds: its file, what it said, and what it warned of.
    fn baked(&self, output: &str, more: &[&str]) -> (Vec<u8>, String, String) {
        let told = self.bake(output, more);
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        assert_eq!(told.status.code(), Some(0), "{}", text(&told.stderr));
        (fs::read(self.path(output)).unwrap(), text(&told.stdout), text(&told.stderr))
    }
}

#[test]
fn the_first_bake_makes_the_file_and_the_next_ones_take_it_up() {
    let bakes = Bakes::new("taken_up");
    let kept = bakes.path("kept.umbrage");
    let reuse = ["--reuse", kept.to_str().unwrap()];
    let (plain, ..) = bakes.baked("plain.glb", &[]);
    let (first, told, warned) = bakes.baked("first.glb", &reuse);
    assert!(told.contains("kept.umbrage") && told.contains("takes up") && warned.is_empty(), "{told}{warned}");
    let on_disk = fs::read(&kept).unwrap();
    let (second, told, warned) = bakes.baked("second.glb", &reuse);
    assert!(told.contains("Took up") && told.contains("no more than a factor") && warned.is_empty(), "{told}{warned}");
    assert!(plain == first && first == second);
    let (_, told, _) =
        bakes.baked("blue.glb", &[&reuse[..], &["--emit", "light=1,2,9", "--reflectance", "red=0.9"]].concat());
    assert!(told.contains("another brightness or colour"), "{told}");
    assert_eq!(fs::read(&kept).unwrap(), on_disk, "the file stays as it is");
}

#[test]
fn a_file_that_does_not_fit_is_replaced_and_one_of_others_is_left() {
    let bakes = Bakes::new("no_fit");
    let kept = bakes.path("kept.umbrage");
    let reuse = ["--reuse", kept.to_str().unwrap()];
    let (plain, ..) = bakes.baked("plain.glb", &reuse);
    let good = fs::read(&kept).unwrap();

    let mut damaged = good.clone();
    damaged[good.len() / 2] ^= 1;
    fs::write(&kept, &damaged).unwrap();
    let (baked, _, warned) = bakes.baked("damaged.glb", &reuse);
    assert!(baked == plain && warned.contains("is damaged") && warned.contains("replaced"), "{warned}");
    assert!(fs::read(&kept).unwrap() == good);

    let (_, _, warned) = bakes.baked("other.glb", &[&reuse[..], &["--max-form-factor", "0.5"]].concat());
    assert!(warned.contains("other options"), "{warned}");
    let (_, _, warned) = bakes.baked("moved.glb", &[&reuse[..], &["--unit", "mm"]].concat());
    assert!(warned.contains("options") || warned.contains("surfaces moved"), "{warned}");

    fs::write(&kept, b"my diary").unwrap();
    let (baked, _, warned) = bakes.baked("foreign.glb", &reuse);
    assert!(baked == plain && warned.contains("is not a kept bake") && warned.contains("left as it is"), "{warned}");
    assert_eq!(fs::read(&kept).unwrap(), b"my diary");
}

/// The checksum at the end of a kept file (IEEE 802.3).
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
    };
    !bytes.iter().fold(!0, step)
}

#[test]
fn a_forged_file_with_a_right_checksum_is_no_panic_and_what_it_says_is_not_believed() {
    let bakes = Bakes::new("forged");
    let kept = bakes.path("kept.umbrage");
    let reuse = ["--reuse", kept.to_str().unwrap()];
    let (plain, ..) = bakes.baked("plain.glb", &reuse);
    let sound = fs::read(&kept).unwrap();
    let (payload, checksum) = sound.split_at(sound.len() - 4);
    assert_eq!(crc32(payload).to_le_bytes(), checksum, "the checksum is known");
    let forge = |change: &dyn Fn(&mut [u8])| {
        let mut forged = payload.to_vec();
        change(&mut forged);
        let checksum = crc32(&forged).to_le_bytes();
        forged.extend(checksum);
        fs::write(&kept, forged).unwrap();
        bakes.baked("forged.glb", &reuse)
    };
    // Numbers that no light and no place can have, wherever numbers of eight bytes may begin.
    let (mut anew, places) = (0, 24);
    for number in 0..places {
        let value = [1e308, f64::NAN, -1e308, f64::INFINITY][number % 4];
        let place = 512 + number * (payload.len() - 600) / places;
        let (glb, _, warned) = forge(&|bytes| bytes[place..place + 8].copy_from_slice(&value.to_le_bytes()));
        if warned.contains("baked anew") {
            assert!(glb == plain, "what is baked anew is the bake");
            anew += 1;
        } else {
            assert!(warned.is_empty(), "{warned}");
        }
    }
    assert!(anew > places / 4, "{anew} of {places} were found out");
    // One of another layout.
    let version = payload.windows(2).position(|two| two == b"0.").unwrap();
    let (glb, _, warned) = forge(&|bytes| bytes[version + 6] = b'1');
    assert!(glb == plain && warned.contains("another version") && warned.contains("baked anew"), "{warned}");
}

#[test]
fn what_makes_no_sense_is_refused_before_the_bake() {
    let bakes = Bakes::new("refused");
    let out = bakes.path("out.glb");
    for more in [&["--time-limit", "5"][..], &["--memory-limit", "5GB"], &["--progressive"]] {
        assert_eq!(bakes.bake("out.glb", &[&["--reuse", "k"], more].concat()).status.code(), Some(2), "{more:?}");
    }
    for file in [out.to_str().unwrap(), "no/such/folder/k"] {
        assert_eq!(bakes.bake("out.glb", &["--reuse", file]).status.code(), Some(1), "{file}");
    }
    assert!(!out.exists());
}
