#version 300 es
// From light to the screen: what the file color.rs says, with its numbers, which are put in below.
precision highp float;
precision highp int;

{{constants}}
centroid in vec3 light;
centroid in float irradiance;
centroid in vec2 uv;
in vec3 corner;

uniform vec3 base;
uniform sampler2D image;
uniform bool textured;
uniform float cutoff; // where the image's alpha is less, there is nothing
uniform int show; // 0 the surfaces, 1 their light alone, 2 irradiance in false colours
uniform bool filmic;
uniform float exposure;
uniform float scaleEnd;
uniform bool wire;

out vec4 pixel;

// Half the width of a line in pixels, and how much of the picture it hides.
const float WIRE_RADIUS = 0.4;
const float WIRE_OPACITY = 0.45;

vec3 displayed(vec3 c) {
  vec3 x = clamp(c * exposure, 0.0, LARGEST);
  if (!filmic) return min(x, 1.0);
  return min((x * (FILMIC_A * x + FILMIC_B)) / (x * (FILMIC_C * x + FILMIC_D) + FILMIC_E), 1.0);
}

vec3 encoded(vec3 c) {
  vec3 curve = SRGB_SCALE * pow(max(c, SRGB_CUT), vec3(1.0 / SRGB_EXPONENT)) - SRGB_OFFSET;
  return mix(curve, SRGB_SLOPE * c, lessThanEqual(c, vec3(SRGB_CUT)));
}

vec3 decoded(vec3 s) {
  vec3 curve = pow((s + SRGB_OFFSET) / SRGB_SCALE, vec3(SRGB_EXPONENT));
  return mix(curve, s / SRGB_SLOPE, lessThanEqual(s, vec3(SRGB_SLOPE * SRGB_CUT)));
}

vec3 onScale(float at) {
  float place = clamp(at, 0.0, 1.0) * float(SEQUENTIAL.length() - 1);
  int from = min(int(place), SEQUENTIAL.length() - 2);
  return mix(SEQUENTIAL[from], SEQUENTIAL[from + 1], place - float(from));
}

void main() {
  if (textured && texture(image, uv).a < cutoff) discard;
  vec3 color;
  if (show == 2) {
    color = onScale(irradiance / scaleEnd);
  } else {
    vec3 seen = light;
    if (show == 0) seen *= base;
    if (show == 0 && textured) seen *= texture(image, uv).rgb;
    color = encoded(displayed(seen));
  }
  if (wire) {
    // Distance from each edge, in pixels.
    vec3 across = dFdx(corner), down = dFdy(corner);
    vec3 away = corner / max(sqrt(across * across + down * down), vec3(1e-9));
    float cover = WIRE_OPACITY * clamp(WIRE_RADIUS + 0.5 - min(away.x, min(away.y, away.z)), 0.0, 1.0);
    vec3 under = decoded(color);
    float line = dot(under, LUMINANCE_WEIGHTS) > CONTRAST_LUMINANCE ? 0.0 : 1.0;
    color = encoded(mix(under, vec3(line), cover));
  }
  pixel = vec4(color, 1.0);
}
