// Surfaces, from light to what is displayed: what the file color.rs of umbrage-picture says, with its numbers, which are put
// before this text. What is written is linear; `finish.wgsl` encodes it.
//
// FARTHER: as if all were this share of its distance farther away; it stays where it is on the screen.
// WIRE: whether triangles are drawn without shared vertices, and their edges with them.
// WIRE_RADIUS, WIRE_OPACITY: half the width of a line in pixels, and how much of the picture it hides.

struct Corner {
  @location(0) position_m: vec3<f32>,
  @location(1) seen: vec3<f32>,
  @location(2) light: vec3<f32>,
  @location(3) irradiance: f32,
  @location(4) uv: vec2<f32>,
  // Where the texture's alpha is less, nothing is drawn.
  @location(5) cutoff: f32,
}

struct Between {
  @builtin(position) clip: vec4<f32>,
  @location(0) @interpolate(perspective, centroid) color: vec3<f32>,
  @location(1) @interpolate(perspective, centroid) irradiance: f32,
  @location(2) @interpolate(perspective, centroid) uv: vec2<f32>,
  // 1 at one corner of the triangle, 0 at the others.
  @location(3) corner: vec3<f32>,
  @location(4) @interpolate(flat) cutoff: f32,
}

@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var image_sampler: sampler;

@vertex
fn place(vertex: Corner, @builtin(vertex_index) index: u32) -> Between {
  var out: Between;
  out.clip = view.clip_from_world * vec4<f32>(vertex.position_m, 1.0);
  out.clip.z -= view.depth_step * (1.0 - 1.0 / (1.0 + FARTHER));
  out.color = select(vertex.seen, vertex.light, view.show == 1u);
  out.irradiance = vertex.irradiance;
  out.uv = vertex.uv;
  out.cutoff = vertex.cutoff;
  let corner = index % 3u;
  out.corner = vec3<f32>(f32(corner == 0u), f32(corner == 1u), f32(corner == 2u));
  return out;
}

fn displayed(color: vec3<f32>) -> vec3<f32> {
  let x = clamp(color * view.exposure, vec3<f32>(0.0), vec3<f32>(LARGEST));
  if view.filmic == 0u {
    return min(x, vec3<f32>(1.0));
  }
  return min((x * (FILMIC_A * x + FILMIC_B)) / (x * (FILMIC_C * x + FILMIC_D) + FILMIC_E), vec3<f32>(1.0));
}

fn decoded(code: vec3<f32>) -> vec3<f32> {
  let curve = pow((code + SRGB_OFFSET) / SRGB_SCALE, vec3<f32>(SRGB_EXPONENT));
  return select(curve, code / SRGB_SLOPE, code <= vec3<f32>(SRGB_SLOPE * SRGB_CUT));
}

fn on_scale(at: f32) -> vec3<f32> {
  var stops = SEQUENTIAL;
  let last = SEQUENTIAL_COUNT - 1;
  let place = clamp(at, 0.0, 1.0) * f32(last);
  let begin = min(i32(place), last - 1);
  return decoded(mix(stops[begin], stops[begin + 1], place - f32(begin)));
}

@fragment
fn shade(in: Between) -> @location(0) vec4<f32> {
  let texel = textureSample(image, image_sampler, in.uv);
  // Distance from each edge, in pixels.
  let across = dpdx(in.corner);
  let down = dpdy(in.corner);
  let away = in.corner / max(sqrt(across * across + down * down), vec3<f32>(1e-9));
  if texel.a < in.cutoff {
    discard;
  }
  var color: vec3<f32>;
  if view.show == 2u {
    color = on_scale(in.irradiance / view.scale_end);
  } else if view.show == 1u {
    color = displayed(in.color);
  } else {
    color = displayed(in.color * texel.rgb);
  }
  if WIRE {
    let nearest = min(away.x, min(away.y, away.z));
    let cover = WIRE_OPACITY * clamp(WIRE_RADIUS + 0.5 - nearest, 0.0, 1.0);
    let line = select(1.0, 0.0, dot(color, LUMINANCE_WEIGHTS) > CONTRAST_LUMINANCE);
    color = mix(color, vec3<f32>(line), cover);
  }
  return vec4<f32>(color, 1.0);
}
