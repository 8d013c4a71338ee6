// From displayed light to the screen's eight bits: encoded as sRGB, and with DITHER dithered, so that a gradient in the dark
// shows no bands. A value that is a code stays that code.
//
// Source of the pattern: J. Jimenez, Next Generation Post Processing in Call of Duty, 2014 (interleaved gradient noise).

@group(0) @binding(0) var drawn: texture_2d<f32>;

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
  let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
  return vec4<f32>(2.0 * corner - 1.0, 0.0, 1.0);
}

fn encoded(color: vec3<f32>) -> vec3<f32> {
  let curve = SRGB_SCALE * pow(max(color, vec3<f32>(SRGB_CUT)), vec3<f32>(1.0 / SRGB_EXPONENT)) - SRGB_OFFSET;
  return select(curve, SRGB_SLOPE * color, color <= vec3<f32>(SRGB_CUT));
}

@fragment
fn finish(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let color = clamp(textureLoad(drawn, vec2<i32>(at.xy), 0).rgb, vec3<f32>(0.0), vec3<f32>(1.0));
  let pixel = floor(at.xy);
  let noise = fract(52.9829189 * fract(0.06711056 * pixel.x + 0.00583715 * pixel.y));
  // Rounding up or down, by how near the value is to each; a hair of a code either way is rounding of half precision.
  let round_up = select(0.5, clamp(noise, 0.06, 0.94), DITHER);
  let codes = floor(255.0 * encoded(color) + round_up);
  return vec4<f32>(codes / 255.0, 1.0);
}
