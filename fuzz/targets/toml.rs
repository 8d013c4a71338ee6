//! The TOML beside a scene.
#![no_main]

use umbrage::scene::cornell::cornell_box;
use umbrage_formats::Overrides;

libfuzzer_sys::fuzz_target!(|text: &str| {
    match Overrides::parse("fuzz.toml", text) {
        Err(error) => assert!(error.to_string().starts_with("fuzz.toml: "), "{error}"),
        Ok(overrides) => {
            let mut scene = cornell_box();
            if overrides.apply(&mut scene, 0.9).is_ok() {
                assert!(scene.materials.iter().all(|m| m.reflectance.max_element() <= 0.9 && m.radiance.is_finite()));
            }
        }
    }
});
