//! The shaders' text: the numbers of the module of colour as WGSL, put before each shader that uses them, so that
//! window and pictures cannot have different ones.

use std::fmt::Write;

use umbrage_picture::color::{ShaderValue, shader_constants};
use umbrage_picture::{WIRE_OPACITY, WIRE_WIDTH_PX};

/// What the shaders of surfaces and lines know of the view.
const VIEW: &str = include_str!("view.wgsl");

/// Triangles without any light are drawn as if they were farther away by this share of their distance: more than the
/// rounding of `f32` makes of it. (On pages it is more, whose depth has 24 bits.)
const DARK_FARTHER: f32 = 2e-5;

/// Draws surfaces, those without any light if they are `dark`, and the edges of triangles if `wire` says so.
///
/// These are constants of the text, and not of the pipeline: OpenGL's pipelines of one text may share a program.
pub(crate) fn surface(dark: bool, wire: bool) -> String {
    let kind = [
        ("FARTHER", float(if dark { DARK_FARTHER } else { 0.0 })),
        ("WIRE", wire.to_string()),
        ("WIRE_RADIUS", float(0.5 * WIRE_WIDTH_PX as f32)),
        ("WIRE_OPACITY", float(WIRE_OPACITY)),
    ];
    let kind: String = kind.iter().map(|(name, value)| format!("const {name} = {value};\n")).collect();
    kind + &constants() + VIEW + include_str!("surface.wgsl")
}

/// Draws lines over them.
pub(crate) fn line() -> String {
    VIEW.to_owned() + include_str!("line.wgsl")
}

/// Makes what a screen takes of what was drawn, dithered or rounded.
pub(crate) fn finish(dither: bool) -> String {
    format!("const DITHER = {dither};\n") + &constants() + include_str!("finish.wgsl")
}

/// Declarations of all constants.
fn constants() -> String {
    let mut text = String::new();
    for (name, value) in shader_constants() {
        // Writing to a string cannot fail.
        let value = match value {
            ShaderValue::Number(number) => float(number),
            ShaderValue::Vector(vector) => vec3(vector),
            ShaderValue::Scale(stops) => {
                let count = stops.len();
                let _ = writeln!(text, "const {name}_COUNT = {count};");
                let stops: Vec<_> = stops.into_iter().map(vec3).collect();
                format!("array<vec3<f32>, {count}>({})", stops.join(", "))
            }
        };
        let _ = writeln!(text, "const {name} = {value};");
    }
    text
}

fn vec3(vector: [f32; 3]) -> String {
    format!("vec3<f32>({})", vector.map(float).join(", "))
}

/// A number that WGSL takes as a float of 32 bits.
fn float(number: f32) -> String {
    format!("{number:?}f")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_floats_and_scales_are_arrays() {
        let text = constants();
        assert!(text.contains("const LARGEST = 65504.0f;\n"), "{text}");
        assert!(text.contains("const LUMINANCE_WEIGHTS = vec3<f32>(0.2126f, 0.7152f, 0.0722f);"), "{text}");
        assert!(text.contains("const SEQUENTIAL = array<vec3<f32>, 9>(vec3<f32>(0.26666668f, "), "{text}");
    }
}
