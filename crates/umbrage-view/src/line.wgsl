// Lines on surfaces: a rectangle on the screen around each, which follows the surface in depth, so that a line is whole
// however steeply its surface is seen. See `marks.rs` for what a line is.

// How much nearer than its surface a line counts, as a share of its distance: more than rounding, less than any gap.
const NEARER = 3e-4;
// How much a rectangle may lie before or behind its line, as a factor: at the horizon of a surface there is no end to it.
const STEEPEST = 2.0;

struct Line {
  @location(0) begin_m: vec3<f32>,
  @location(1) end_m: vec3<f32>,
  // Of its surface: where it looks away from the eye, the line is not drawn.
  @location(2) normal: vec3<f32>,
  @location(3) color: vec3<f32>,
  @location(4) radius_px: f32,
}

struct Between {
  @builtin(position) clip: vec4<f32>,
  @location(0) color: vec3<f32>,
  // How far beside the middle, and how far that may be, in pixels.
  @location(1) @interpolate(linear) beside_px: f32,
  @location(2) @interpolate(flat) radius_px: f32,
}

// A point of clip space that is before the near plane is moved along the line to it.
fn before_eye(clip: vec4<f32>, other: vec4<f32>) -> vec4<f32> {
  if clip.w >= view.near {
    return clip;
  }
  return mix(clip, other, (view.near - clip.w) / (other.w - clip.w));
}

@vertex
fn place(line: Line, @builtin(vertex_index) index: u32) -> Between {
  var out: Between;
  out.color = line.color;
  out.radius_px = line.radius_px;
  out.clip = vec4<f32>(0.0, 0.0, 2.0, 1.0);
  let begin = view.clip_from_world * vec4<f32>(line.begin_m, 1.0);
  let end = view.clip_from_world * vec4<f32>(line.end_m, 1.0);
  let offset_m = line.begin_m - view.eye;
  let hidden = max(begin.w, end.w) < view.near || dot(line.normal, offset_m) >= 0.0;
  if hidden {
    return out;
  }
  let from_clip = before_eye(begin, end);
  let to_clip = before_eye(end, begin);
  let half_px = 0.5 * view.size_px;
  let from_px = from_clip.xy / from_clip.w * half_px;
  let to_px = to_clip.xy / to_clip.w * half_px;
  let length_px = distance(from_px, to_px);
  let along = select(vec2<f32>(1.0, 0.0), (to_px - from_px) / length_px, length_px > 1e-6);
  let beside = vec2<f32>(-along.y, along.x);
  // Half a pixel more, in which it fades.
  let reach_px = line.radius_px + 0.5;
  let side = select(-1.0, 1.0, (index & 1u) == 1u);
  let last = index >= 2u;
  let middle_px = select(from_px - 0.5 * along, to_px + 0.5 * along, last);
  let place = (middle_px + side * reach_px * beside) / half_px;
  // Where the ray through that pixel meets the surface.
  let depth = select(from_clip.w, to_clip.w, last);
  let ray = view.ahead + place.x * view.right + place.y * view.up;
  let slope = dot(line.normal, ray);
  var met = depth;
  if abs(slope) > 1e-9 {
    met = clamp(dot(line.normal, offset_m) / slope, depth / STEEPEST, depth * STEEPEST);
  }
  met = max(met, view.near);
  out.clip = vec4<f32>(place * met, view.depth_scale * met + view.depth_step / (1.0 - NEARER), met);
  out.beside_px = side * reach_px;
  return out;
}

@fragment
fn shade(in: Between) -> @location(0) vec4<f32> {
  return vec4<f32>(in.color, clamp(in.radius_px + 0.5 - abs(in.beside_px), 0.0, 1.0));
}
