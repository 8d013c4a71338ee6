//! The numbers of the module of colour as GLSL, so that page and pictures cannot have different ones.

use std::fmt::Write;

use umbrage_picture::color::{ShaderValue, shader_constants};

/// Declarations of all constants.
pub(crate) fn glsl_constants() -> String {
    let mut text = String::new();
    for (name, value) in shader_constants() {
        let declaration = match value {
            ShaderValue::Number(number) => format!("const float {name} = {};", float(number)),
            ShaderValue::Vector(vector) => format!("const vec3 {name} = {};", vec3(vector)),
            ShaderValue::Scale(stops) => {
                let count = stops.len();
                let stops: Vec<_> = stops.into_iter().map(vec3).collect();
                format!("const vec3 {name}[{count}] = vec3[{count}]({});", stops.join(", "))
            }
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{declaration}");
    }
    text
}

fn vec3(vector: [f32; 3]) -> String {
    format!("vec3({})", vector.map(float).join(", "))
}

/// A number that GLSL takes as a float: with a point or an exponent.
fn float(number: f32) -> String {
    format!("{number:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_floats_and_scales_are_arrays() {
        let text = glsl_constants();
        assert!(text.contains("const float LARGEST = 65504.0;\n"), "{text}");
        assert!(text.contains("const vec3 LUMINANCE_WEIGHTS = vec3(0.2126, 0.7152, 0.0722);"), "{text}");
        assert!(
            text.contains("const vec3 SEQUENTIAL[9] = vec3[9](vec3(0.26666668, 0.003921569, 0.32941177)"),
            "{text}"
        );
    }
}
