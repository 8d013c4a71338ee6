//! A baked scene as a web page in one file.
//!
//! The page draws with WebGL2 what a picture of `umbrage-picture` shows: base colour x texture x light, interpolated
//! between vertices, with the same numbers for exposure, tone curve, sRGB and false colours. It asks no network for
//! anything (its content security policy forbids it), so it opens from a disk, and will in many years.
//!
//! HTML, style, scripts and shaders are files of their own in `web`, which are put together here as they are:
//!
//! | file | holds |
//! |---|---|
//! | `page.html`, `page.css` | what is seen around the scene |
//! | `data.js` | the scene's tables |
//! | `camera.js` | the camera, its matrix, picking |
//! | `draw.js`, `surface.vert`, `surface.frag` | drawing, and the idea of colour |
//! | `controls.js` | mouse, keyboard, touch, panel; it is last, and begins |
//!
//! Holds: no text of a file can leave the place where it stands: it is escaped for HTML and for scripts; the same file
//! gives the same page.

mod scene;
mod shader;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use umbrage_formats::BakedFile;
use umbrage_picture::Camera;

const PAGE: &str = include_str!("../web/page.html");
const STYLE: &str = include_str!("../web/page.css");
const VERTEX_SHADER: &str = include_str!("../web/surface.vert");
const FRAGMENT_SHADER: &str = include_str!("../web/surface.frag");
const SCRIPTS: [&str; 4] = [
    include_str!("../web/data.js"),
    include_str!("../web/camera.js"),
    include_str!("../web/draw.js"),
    include_str!("../web/controls.js"),
];

/// How a page is made.
#[derive(Clone, Debug)]
pub struct PageOptions {
    /// Its title.
    pub title: String,
    /// From where the scene is seen first, where the file has no camera; the page goes as near as the window allows.
    pub camera: Camera,
}

/// The page of a baked file.
pub fn page(file: &BakedFile, options: &PageOptions) -> String {
    let scene = scene::lay_out(file, &options.camera);
    let fragment_shader = FRAGMENT_SHADER.replace("{{constants}}", &shader::glsl_constants());
    let mut script = String::new();
    for (name, text) in [("VERTEX_SHADER", VERTEX_SHADER), ("FRAGMENT_SHADER", &fragment_shader)] {
        script += &format!("const {name} = {};\n", in_script(&serde_json::Value::from(text)));
    }
    for text in SCRIPTS {
        script += text;
    }
    let title = escaped(&options.title);
    let about = in_script(&scene.about);
    let data = STANDARD.encode(&scene.tables);
    fill(PAGE, &[("title", &title), ("style", STYLE), ("about", &about), ("data", &data), ("script", &script)])
}

/// A template with its gaps filled: what is put in is not looked at again.
fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let size = values.iter().map(|(_, value)| value.len()).sum::<usize>();
    let mut text = String::with_capacity(template.len() + size);
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        text += before;
        rest = after;
        if let Some((name, after)) = rest.split_once("}}") {
            text += values.iter().find(|(known, _)| *known == name).map_or("", |(_, value)| value);
            rest = after;
        }
    }
    text + rest
}

/// Text for the content or a quoted attribute of an element.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;").replace('\'', "&#39;")
}

/// A JSON value for the content of a script, which only `<` can end.
fn in_script(value: &serde_json::Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_filled_once() {
        assert_eq!(fill("a {{x}} b {{y}} {{x}}", &[("x", "{{y}}"), ("y", "2")]), "a {{y}} b 2 {{y}}");
        assert_eq!(fill("none", &[]), "none");
    }

    #[test]
    fn no_text_leaves_its_place() {
        assert_eq!(escaped("<b title='a\"&'>"), "&lt;b title=&#39;a&quot;&amp;&#39;&gt;");
        let value = serde_json::Value::from("</script><!--");
        assert_eq!(in_script(&value), r#""\u003c/script>\u003c!--""#);
        assert_eq!(serde_json::from_str::<serde_json::Value>(&in_script(&value)).unwrap(), value);
    }

    #[test]
    fn every_gap_of_the_page_is_known() {
        let known = ["title", "style", "about", "data", "script"];
        for part in PAGE.split("{{").skip(1) {
            let name = part.split("}}").next().unwrap();
            assert!(known.contains(&name), "{name}");
        }
    }

    #[test]
    fn the_page_reaches_for_nothing() {
        let all = [PAGE, STYLE, VERTEX_SHADER, FRAGMENT_SHADER].into_iter().chain(SCRIPTS);
        for word in ["http://", "https://", "src=", "@import", "fetch(", "XMLHttpRequest", "import("] {
            assert!(all.clone().all(|text| !text.contains(word)), "{word}");
        }
    }
}
