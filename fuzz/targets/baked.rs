//! Baked files as they are read back, and as scenes.
#![no_main]

use umbrage_formats::read_baked_bytes;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    umbrage_fuzz::read("glb", bytes);
    match read_baked_bytes("no/such/folder/fuzz.glb", bytes.to_vec()) {
        Err(error) => assert!(error.to_string().starts_with("no/such/folder/"), "{error}"),
        Ok(file) => {
            for part in &file.parts {
                let count = part.positions_m.len();
                assert!(part.triangles.as_flattened().iter().all(|&i| (i as usize) < count), "an index out of range");
                assert!(part.positions_m.as_flattened().iter().all(|x| x.is_finite()), "not finite");
                assert!(part.irradiance.len() == count && part.color.len() == count);
            }
        }
    }
});
