//! What a surface shows of an image on average.

use glam::{DVec2, DVec3};
use umbrage::scene::Wrap;
use umbrage_picture::{MeanColor, Seen};

/// How a picture repeats an image that a scene repeats so.
pub fn picture_wrap(wrap: Wrap) -> umbrage_picture::Wrap {
    match wrap {
        Wrap::Repeat => umbrage_picture::Wrap::Repeat,
        Wrap::Mirror => umbrage_picture::Wrap::Mirror,
        Wrap::Clamp => umbrage_picture::Wrap::Clamp,
    }
}

/// Light and alpha of an image over triangles, weighted by area in the world.
pub(crate) fn over(
    image: &MeanColor,
    wrap: [Wrap; 2],
    triangles: impl Iterator<Item = [usize; 3]>,
    positions_m: &[DVec3],
    uvs: &[DVec2],
) -> Seen {
    let wrap = wrap.map(picture_wrap);
    let mut sum = Seen::default();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| positions_m[i]);
        let area_m2 = 0.5 * (b - a).cross(c - a).length();
        if area_m2.is_finite() {
            sum = sum.plus(area_m2, image.over(triangle.map(|i| uvs[i].to_array()), wrap));
        }
    }
    sum
}
