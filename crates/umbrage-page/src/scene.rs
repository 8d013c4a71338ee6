//! The scene of a page: facts as JSON, and tables as bytes.
//!
//! Idea: the page needs neither a glTF reader nor what a file may hold besides; so parts of one look become one, and
//! the tables are laid out as a graphics processor takes them. Positions stay relative to the file's origin.
//!
//! Holds: materials cover all indices, one after the other; the same file gives the same text.
//!
//! ```text
//! positions 3 f32 | light 3 f32 | irradiance f32 | uv 2 f32, if there are textures | indices u32 | images
//! ```

use serde_json::{Value, json};
use umbrage_formats::{BakedCamera, BakedFile, BakedTexture, TextureWrap};
use umbrage_picture::{Camera, color, nice_ceiling};

/// What the scripts get: see `web/data.js`.
pub(crate) struct PageScene {
    pub(crate) about: Value,
    pub(crate) tables: Vec<u8>,
}

/// Triangles of one look: the same base colour, texture and mask.
struct Look {
    base: [f32; 3],
    texture: Option<BakedTexture>,
    /// The least alpha that is drawn; 0 draws all.
    cutoff: f32,
    lit: Vec<u32>,
    /// Those that get no light at any corner. They are drawn last: see `web/draw.js`.
    dark: Vec<u32>,
}

/// Lays out a baked file; the page looks at it as `outside` does where the file has no camera.
pub(crate) fn lay_out(file: &BakedFile, outside: &Camera) -> PageScene {
    let looks = looks(file);
    let mut images: Vec<BakedTexture> = Vec::new();
    for texture in looks.iter().filter_map(|look| look.texture) {
        if !images.contains(&texture) {
            images.push(texture);
        }
    }
    let (mut first, mut materials) = (0, Vec::new());
    for Look { base, texture, cutoff, lit, dark } in &looks {
        let number = images.iter().position(|known| Some(*known) == *texture);
        materials.push(json!({"first": first, "lit": lit.len(), "dark": dark.len(), "base": base, "texture": number,
            "cutoff": cutoff}));
        first += lit.len() + dark.len();
    }
    let textures: Vec<Value> = images
        .iter()
        .map(|texture| json!({"bytes": file.images[texture.image].len(), "wrap": texture.wrap.map(wrap_name)}))
        .collect();
    let [low, high] = bounds_m(file);
    let background = color::BACKGROUND.map(|c| color::srgb_from_linear(f64::from(c)));
    let about = json!({
        "vertices": file.vertex_count(),
        "triangles": file.triangle_count(),
        "materials": materials,
        "textures": textures,
        "origin": file.origin_m.to_array(),
        "low": low,
        "high": high,
        "cameras": cameras(file, outside),
        "background": background,
        "scale": color::SEQUENTIAL,
        "scaleEnd": scale_end(file),
        "lumensPerWatt": color::LUMENS_PER_WATT,
        "photometric": file.photometric,
        "facts": facts(file),
    });
    PageScene { about, tables: tables(file, &looks, &images) }
}

/// Where the scale of false colours ends, in the file's unit.
fn scale_end(file: &BakedFile) -> f64 {
    nice_ceiling(file.irradiance_quantile(color::SHARE_WITHIN_SCALE, color::LUMINANCE_WEIGHTS))
}

/// The triangles by look, in the order in which the looks first occur.
fn looks(file: &BakedFile) -> Vec<Look> {
    let mut looks: Vec<Look> = Vec::new();
    let mut first_vertex = 0;
    for part in &file.parts {
        let [red, green, blue, _] = part.base_color;
        let (base, texture, cutoff) = ([red, green, blue], part.texture, part.cutoff.unwrap_or(0.0));
        let number = looks.iter().position(|look| (look.base, look.texture, look.cutoff) == (base, texture, cutoff));
        let number = number.unwrap_or_else(|| {
            looks.push(Look { base, texture, cutoff, lit: Vec::new(), dark: Vec::new() });
            looks.len() - 1
        });
        let is_dark = |vertex: u32| part.color[vertex as usize][..3] == [0.0; 3];
        for &triangle in &part.triangles {
            let look = &mut looks[number];
            let table = if triangle.into_iter().all(is_dark) { &mut look.dark } else { &mut look.lit };
            table.extend(triangle.map(|vertex| first_vertex + vertex));
        }
        first_vertex += part.positions_m.len() as u32;
    }
    looks
}

fn tables(file: &BakedFile, looks: &[Look], images: &[BakedTexture]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut floats = |values: &[f32]| values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    for part in &file.parts {
        floats(part.positions_m.as_flattened());
    }
    for part in &file.parts {
        floats(part.light(file.exposure_k).as_flattened());
    }
    for part in &file.parts {
        let irradiance: Vec<f32> = part.irradiance.iter().map(|&e| color::luminance(e)).collect();
        floats(&irradiance);
    }
    if !images.is_empty() {
        for part in &file.parts {
            if part.uvs.is_empty() {
                floats(&vec![0.0; 2 * part.positions_m.len()]);
            } else {
                floats(part.uvs.as_flattened());
            }
        }
    }
    for index in looks.iter().flat_map(|look| look.lit.iter().chain(&look.dark)) {
        bytes.extend(index.to_le_bytes());
    }
    for texture in images {
        bytes.extend(&file.images[texture.image]);
    }
    bytes
}

fn wrap_name(wrap: TextureWrap) -> &'static str {
    match wrap {
        TextureWrap::Repeat => "REPEAT",
        TextureWrap::Mirror => "MIRRORED_REPEAT",
        TextureWrap::Clamp => "CLAMP_TO_EDGE",
    }
}

/// The box around all vertices, relative to the origin, in metres.
fn bounds_m(file: &BakedFile) -> [[f32; 3]; 2] {
    let mut all = file.parts.iter().flat_map(|part| &part.positions_m).copied();
    let Some(first) = all.next() else { return [[0.0; 3]; 2] };
    all.fold([first, first], |[low, high], p| {
        [std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))]
    })
}

/// The file's cameras, or the one from outside, relative to the origin.
fn cameras(file: &BakedFile, outside: &Camera) -> Vec<Value> {
    let told = |name: &str, camera: &Camera, fitted: bool| {
        json!({
            "name": name,
            "eye": (camera.eye_m - file.origin_m).to_array(),
            "target": (camera.target_m - file.origin_m).to_array(),
            "up": camera.up.to_array(),
            "fov": camera.fov_y_deg,
            "fitted": fitted,
        })
    };
    if file.cameras.is_empty() {
        return vec![told("outside", outside, true)];
    }
    let [low, high] = bounds_m(file).map(|p| p.map(f64::from));
    let size_m = low.iter().zip(high).map(|(low, high)| (high - low).powi(2)).sum::<f64>().sqrt();
    let all = file.cameras.iter().enumerate().map(|(number, camera)| {
        let &BakedCamera { eye_m, ahead, up, fov_y_deg, ref name } = camera;
        let name = if name.is_empty() { format!("camera {}", number + 1) } else { name.clone() };
        // What the camera turns around lies well in the scene.
        told(&name, &Camera { eye_m, target_m: eye_m + 0.25 * size_m * ahead, up, fov_y_deg }, false)
    });
    all.collect()
}

/// What is worth knowing about the bake: names and values, ready to be read.
fn facts(file: &BakedFile) -> Vec<[String; 2]> {
    let mut facts = vec![
        ["triangles".to_owned(), file.triangle_count().to_string()],
        ["vertices".to_owned(), file.vertex_count().to_string()],
    ];
    for (name, value) in &file.extras {
        let value = match value {
            Value::String(text) => text.clone(),
            Value::Bool(yes) => if *yes { "yes" } else { "no" }.to_owned(),
            Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), short),
            _ => continue,
        };
        facts.push([name.replace('_', " "), value]);
    }
    facts
}

/// A number to four digits.
fn short(x: f64) -> String {
    if x == x.trunc() && x.abs() < 1e9 {
        return format!("{x}");
    }
    if (1e-3..1e6).contains(&x.abs()) { format!("{:.4}", x) } else { format!("{x:.3e}") }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use serde_json::Map;
    use umbrage_formats::BakedFilePart;

    use super::*;

    /// A square of two triangles, one of them without light, `at` metres to the right.
    fn square(at: f32, base: f32, texture: Option<BakedTexture>) -> BakedFilePart {
        BakedFilePart {
            node_name: String::new(),
            name: String::new(),
            material_name: String::new(),
            positions_m: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| [at + x, y, 0.0]).into(),
            normals: vec![[0.0, 0.0, 1.0]; 4],
            color: vec![[0.0, 0.0, 0.0, 1.0], [0.5, 0.5, 0.5, 1.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]],
            base_color: [base, base, base, 1.0],
            texture,
            cutoff: None,
            uvs: if texture.is_some() { vec![[0.25, 0.75]; 4] } else { Vec::new() },
            emission: None,
            irradiance: vec![[at; 3]; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        }
    }

    fn file(parts: Vec<BakedFilePart>) -> BakedFile {
        let images = vec![Vec::new(), b"image".to_vec()];
        let (name, cameras) = (String::new(), Vec::new());
        BakedFile {
            name,
            origin_m: DVec3::X,
            parts,
            cameras,
            images,
            exposure_k: 1.0,
            photometric: false,
            extras: Map::new(),
        }
    }

    fn outside() -> Camera {
        Camera::looking(DVec3::new(1.0, 0.0, 9.0), DVec3::X, 40.0)
    }

    fn indices(scene: &PageScene, from: usize) -> Vec<u32> {
        let words = scene.tables[from..].chunks_exact(4);
        words.map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect()
    }

    #[test]
    fn parts_of_one_look_are_one_and_what_has_no_light_comes_last() {
        let scene =
            lay_out(&file(vec![square(0.0, 0.5, None), square(2.0, 0.7, None), square(4.0, 0.5, None)]), &outside());
        assert_eq!(
            scene.about["materials"],
            json!([
                {"first": 0, "lit": 6, "dark": 6, "base": [0.5f32, 0.5f32, 0.5f32], "texture": null, "cutoff": 0.0},
                {"first": 12, "lit": 3, "dark": 3, "base": [0.7f32, 0.7f32, 0.7f32], "texture": null, "cutoff": 0.0},
            ])
        );
        // Twelve vertices of seven numbers, then the indices.
        let expected = [[0, 1, 2, 8, 9, 10], [0, 2, 3, 8, 10, 11]].concat();
        assert_eq!(indices(&scene, 12 * 7 * 4), [expected, vec![4, 5, 6, 4, 6, 7]].concat());
        assert_eq!((&scene.about["low"], &scene.about["high"]), (&json!([0.0, 0.0, 0.0]), &json!([5.0, 1.0, 0.0])));
        // Relative to the origin, which is at x = 1.
        assert_eq!(scene.about["cameras"][0]["eye"], json!([0.0, 0.0, 9.0]));
    }

    #[test]
    fn images_follow_the_tables_and_vertices_without_texture_have_a_place() {
        let texture = BakedTexture { image: 1, wrap: [TextureWrap::Clamp, TextureWrap::Mirror] };
        let scene = lay_out(&file(vec![square(0.0, 0.5, None), square(2.0, 0.5, Some(texture))]), &outside());
        assert_eq!(scene.about["textures"], json!([{"bytes": 5, "wrap": ["CLAMP_TO_EDGE", "MIRRORED_REPEAT"]}]));
        assert_eq!(scene.about["materials"][0]["texture"], json!(null));
        assert_eq!(scene.about["materials"][1]["texture"], json!(0));
        assert_eq!(scene.tables.len(), 8 * 9 * 4 + 12 * 4 + 5);
        assert!(scene.tables.ends_with(b"image"));
        let uvs = &scene.tables[8 * 7 * 4..8 * 9 * 4];
        assert!(uvs[..32].iter().all(|byte| *byte == 0) && uvs[32..36] == 0.25f32.to_le_bytes());
    }
}
