//! Why a scene that is valid in itself cannot be prepared.

use crate::progress::Cancelled;

/// Why a scene cannot be prepared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PrepareError {
    /// The progress callback asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The scene is so large or so small that single precision cannot hold it.
    #[error("{place}: the scene measures {extent_m} m, and only {least_m} m to {most_m} m can be held: check its unit")]
    Extent {
        /// The polygon that reaches farthest.
        place: String,
        /// Largest side of the scene's bounding box, in metres.
        extent_m: f64,
        /// The least extent that can be held, in metres.
        least_m: f64,
        /// The largest extent that can be held, in metres.
        most_m: f64,
    },
    /// Polygons meet each other so often that cutting them along all of these lines would end in nothing but dust, after hours.
    #[error(
        "{polygons} polygons cross or overlap each other in more than {limit} places: remove those that are there several times; \
         those that cross in different planes are left uncut with --no-intersect"
    )]
    Entangled {
        /// How many polygons there are.
        polygons: usize,
        /// In how many places they may meet.
        limit: usize,
    },
    /// No polygon has an area.
    #[error("{place}: has no area{}: nothing can be baked", of_others(*others))]
    NoArea {
        /// The first polygon.
        place: String,
        /// How many other polygons there are.
        others: usize,
    },
}

/// That other polygons are no better.
fn of_others(others: usize) -> String {
    match others {
        0 => String::new(),
        1 => ", nor has the other polygon".into(),
        n => format!(", nor has any of the other {n} polygons"),
    }
}
