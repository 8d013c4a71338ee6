//! What no scene can pass: values beyond are of broken files, and would overflow when they are multiplied.

/// The greatest radiance in W/(m2 sr), intensity in W/sr and irradiance in W/m2 of a light: the sun's radiance is 1e7. What is
/// greater comes of a broken file, and its squares would not be finite.
pub const MAX_BRIGHTNESS: f64 = 1e15;

/// The greatest coordinate, in metres: a thousand times the way to the moon. What is greater comes of a broken file.
pub const MAX_COORDINATE_M: f64 = 4e11;
