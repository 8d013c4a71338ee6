#version 300 es
// Places a vertex, and hands on what the fragments interpolate.
precision highp float;

layout(location = 0) in vec3 position_m;
layout(location = 1) in vec3 vertexLight;
layout(location = 2) in float vertexIrradiance;
layout(location = 3) in vec2 vertexUv;

uniform mat4 clipFromWorld;

centroid out vec3 light;
centroid out float irradiance;
centroid out vec2 uv;
// 1 at one corner of the triangle, 0 at the others: where triangles are drawn without shared vertices.
out vec3 corner;

void main() {
  gl_Position = clipFromWorld * vec4(position_m, 1.0);
  light = vertexLight;
  irradiance = vertexIrradiance;
  uv = vertexUv;
  corner = vec3(0.0);
  corner[gl_VertexID % 3] = 1.0;
}
