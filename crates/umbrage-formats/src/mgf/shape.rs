//! What each statement of a surface stands for, in the frame in which it is written.

use glam::DVec3;

use super::context::Context;
use super::hole;
use super::solid::{self, Solid};
use crate::FormatError;
use crate::text::{EXPORT_AGAIN, Place};

/// A vertex context.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vertex {
    /// `p`
    pub(super) position: DVec3,
    /// `n`; 0 where there is none.
    pub(super) normal: DVec3,
}

/// A statement of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Statement<'a> {
    pub(super) place: Place<'a>,
    pub(super) keyword: &'a str,
    pub(super) words: &'a [&'a str],
    pub(super) vertices: &'a Context<Vertex>,
    pub(super) segments: usize,
}

impl Statement<'_> {
    /// A polygon (`f`), or one with holes (`fh`, loops with `-` between), and what finding its seams costs. A loop with
    /// fewer than three corners is left out, a face without an outline is no polygon. Where all corners of a face without
    /// holes have a normal, the face stands for a smooth surface.
    pub(super) fn face(&self) -> Result<(Option<Solid>, u64), FormatError> {
        let loops = self.words.split(|word| self.keyword == "fh" && *word == "-");
        let loops = loops.map(|names| names.iter().map(|name| self.position(name)).collect());
        let mut loops = loops.collect::<Result<Vec<Vec<DVec3>>, _>>()?;
        let outlined = loops.first().is_some_and(|outline| outline.len() >= 3);
        loops.retain(|corners| corners.len() >= 3);
        if !outlined {
            return Ok((None, 0));
        }
        if loops.len() > 1 {
            return Ok((Some(Solid::polygon(hole::bridged(&loops), Vec::new())), hole::cost(&loops)));
        }
        let normal = |name: &&str| self.vertices.get(self.place, name).ok().and_then(|v| v.normal.try_normalize());
        let normals = self.words.iter().map(normal).collect::<Option<_>>().unwrap_or_default();
        Ok((loops.pop().map(|corners| Solid::polygon(corners, normals)), 0))
    }

    /// The polygons of another shape, and whether it is curved.
    pub(super) fn solid(&self) -> Result<(Solid, bool), FormatError> {
        let segments = self.segments;
        let solid = match (self.keyword, self.words) {
            ("sph", [centre, radius]) => {
                let centre = self.position(centre)?;
                solid::sphere(centre, self.radius(radius)?, segments)
            }
            ("cyl", [low, radius, high]) => {
                let ends = self.ends(low, high)?;
                let radius = self.radius(radius)?;
                solid::cone(ends, [radius; 2], segments)
            }
            ("cone", [low, low_radius, high, high_radius]) => {
                let ends = self.ends(low, high)?;
                let radii = [self.place.finite(low_radius)?, self.place.finite(high_radius)?];
                if radii == [0.0; 2] || radii[0] * radii[1] < 0.0 {
                    return Err(self.bad("has radii that are both 0 or of two signs"));
                }
                solid::cone(ends, radii, segments)
            }
            ("ring", [centre, inner, outer]) => {
                let (centre, normal) = self.position_and_normal(centre)?;
                let radii = [self.place.finite(inner)?, self.place.finite(outer)?];
                if !(radii[0] >= 0.0 && radii[1] > radii[0]) {
                    return Err(self.bad("needs an inner radius of 0 or more, and a larger outer one"));
                }
                solid::ring(centre, normal, radii, segments)
            }
            ("torus", [centre, inner, outer]) => {
                let (centre, normal) = self.position_and_normal(centre)?;
                let radii = [self.place.finite(inner)?, self.place.finite(outer)?];
                if radii[1].abs() <= radii[0].abs() || radii[0] * radii[1] < 0.0 {
                    return Err(self.bad("needs radii of one sign, the second larger"));
                }
                solid::torus(centre, normal, radii, segments)
            }
            ("prism", [names @ .., length]) if names.len() >= 3 => {
                let face = names.iter().map(|name| self.position(name)).collect::<Result<Vec<_>, _>>()?;
                let length = self.radius(length)?;
                let prism = solid::prism(&face, length).ok_or_else(|| self.bad("has a face without area"))?;
                return Ok((prism, false));
            }
            _ => return Err(self.bad(&format!("cannot have {} arguments", self.words.len()))),
        };
        Ok((solid, true))
    }

    fn bad(&self, what: &str) -> FormatError {
        self.place.bad(format!("{} {what}", self.keyword), EXPORT_AGAIN)
    }

    fn position(&self, name: &str) -> Result<DVec3, FormatError> {
        self.vertices.get(self.place, name).map(|vertex| vertex.position)
    }

    fn position_and_normal(&self, name: &str) -> Result<(DVec3, DVec3), FormatError> {
        let vertex = self.vertices.get(self.place, name)?;
        match vertex.normal.try_normalize() {
            Some(normal) => Ok((vertex.position, normal)),
            None => Err(self.bad("needs a vertex with a normal (n)")),
        }
    }

    /// The ends of an axis.
    fn ends(&self, low: &str, high: &str) -> Result<[DVec3; 2], FormatError> {
        let ends = [self.position(low)?, self.position(high)?];
        match (ends[1] - ends[0]).try_normalize() {
            Some(_) => Ok(ends),
            None => Err(self.bad("has both ends at one point")),
        }
    }

    /// A radius or a length, which may be negative.
    fn radius(&self, word: &str) -> Result<f64, FormatError> {
        match self.place.finite(word)? {
            0.0 => Err(self.bad("has a size of 0")),
            radius => Ok(radius),
        }
    }
}
