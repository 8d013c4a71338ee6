//! Kept bakes whose bytes were changed by somebody who knows the checksum: they are refused, or bake to a sound mesh.
#![no_main]

use std::sync::LazyLock;

use umbrage::bake::BakeSettings;
use umbrage::progress::Progress;
use umbrage::rebake::{bake_to_reuse, rebake};
use umbrage::scene::Scene;
use umbrage::scene::cornell::cornell_box;
use umbrage::shade::ShadeSettings;
use umbrage_formats::{kept_bytes, kept_from_bytes};

static KEPT: LazyLock<(Scene, BakeSettings, Vec<u8>)> = LazyLock::new(|| {
    let (scene, tolerance) = (cornell_box(), 1.0);
    let settings =
        BakeSettings { shade: ShadeSettings { tolerance, ..ShadeSettings::default() }, ..BakeSettings::default() };
    let (_, kept) = bake_to_reuse(&scene, &settings, Progress::silent()).expect("a bake");
    let bytes = kept_bytes(&kept).expect("its bytes");
    (scene, settings, bytes)
});

libfuzzer_sys::fuzz_target!(|changes: Vec<(u32, [u8; 8])>| {
    let (scene, settings, bytes) = &*KEPT;
    // Behind the head, before the checksum.
    let (head, end) = (32, bytes.len() - 4);
    let mut forged = bytes[..end].to_vec();
    for (place, eight) in changes.into_iter().take(4) {
        let place = head + place as usize % (end - head - 8);
        forged[place..place + 8].copy_from_slice(&eight);
    }
    if let Ok(kept) = kept_from_bytes(forged)
        && let Ok((baked, _)) = rebake(scene, settings, &kept, Progress::silent())
    {
        assert_eq!(baked.mesh.validate(), Ok(()));
    }
});
