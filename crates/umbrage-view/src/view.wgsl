// The view: see `lens.rs`, which fills it in. Depth is reversed: 1 at the near plane, 0 at the far one.
struct View {
  clip_from_world: mat4x4<f32>,
  eye: vec3<f32>,
  // Clip z is depth_scale w + depth_step, w being the distance along the view.
  depth_scale: f32,
  // To the right and upper edge of the picture at distance 1 along the view.
  right: vec3<f32>,
  depth_step: f32,
  up: vec3<f32>,
  near: f32,
  ahead: vec3<f32>,
  exposure: f32,
  size_px: vec2<f32>,
  scale_end: f32,
  // 0 the surfaces, 1 their light alone, 2 irradiance in false colours.
  show: u32,
  filmic: u32,
}

@group(0) @binding(0) var<uniform> view: View;
