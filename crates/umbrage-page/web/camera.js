// The camera: an eye, the direction in which it looks (yaw about +Y, pitch up), and the distance of the point around
// which it turns. Its right hand depends on yaw alone, so looking straight down or up is nothing special.

const DEGREE = Math.PI / 180;
const add = (a, b, times = 1) => a.map((x, i) => x + times * b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const span = (a) => Math.hypot(...a);

// How much farther back than needed a camera stands.
const MARGIN = 1.03;
const camera = { eye: [0, 0, 1], yaw: 0, pitch: 0, distance: 1, fov: 40 };
const diagonal = span(add(about.high, about.low, -1)) || 1;
const middle = about.low.map((low, i) => (low + about.high[i]) / 2);

function frame() {
  const [sy, cy, sp, cp] = [Math.sin(camera.yaw), Math.cos(camera.yaw), Math.sin(camera.pitch), Math.cos(camera.pitch)];
  const right = [cy, 0, sy];
  const ahead = [sy * cp, sp, -cy * cp];
  return { right, ahead, up: cross(right, ahead) };
}

const target = () => add(camera.eye, frame().ahead, camera.distance);

// `up` tells where a view straight down or up has its upper edge.
function look(eye, at, up) {
  const ahead = add(at, eye, -1);
  const distance = span(ahead);
  if (!(distance > 0)) return;
  const level = Math.hypot(ahead[0], ahead[2]);
  let heading = ahead;
  if (level <= 1e-6 * distance) heading = up.map((x) => -Math.sign(ahead[1]) * x);
  camera.eye = eye;
  camera.distance = distance;
  camera.yaw = Math.atan2(heading[0], -heading[2]);
  camera.pitch = Math.atan2(ahead[1], level);
}

function turn(yaw, pitch, around) {
  const kept = target();
  camera.yaw += yaw;
  camera.pitch = Math.min(Math.max(camera.pitch + pitch, -90 * DEGREE), 90 * DEGREE);
  if (around) camera.eye = add(kept, frame().ahead, -camera.distance);
}

// Sideways and up, in metres.
function move(right, up, ahead) {
  const f = frame();
  camera.eye = add(add(add(camera.eye, f.right, right), f.up, up), f.ahead, ahead);
}

// Towards what is in the middle, which stays where it is.
function approach(factor) {
  const kept = target();
  camera.distance = Math.min(Math.max(camera.distance * factor, 1e-4 * diagonal), 100 * diagonal);
  camera.eye = add(kept, frame().ahead, -camera.distance);
}

// A camera of the list; where it is not the file's own, as near as the whole scene can be seen from in this window.
function start(number, aspect) {
  const { eye, target: at, up, fov, fitted } = about.cameras[number];
  camera.fov = fov;
  look(eye, at, up);
  if (!fitted) return;
  const f = frame();
  const slope = Math.tan((fov * DEGREE) / 2);
  const half = add(about.high, middle, -1);
  camera.distance = 1e-3 * diagonal;
  for (let i = 0; i < 8; i++) {
    const corner = half.map((x, axis) => ((i >> axis) & 1 ? x : -x));
    const [sideways, upwards] = [Math.abs(dot(corner, f.right)) / aspect, Math.abs(dot(corner, f.up))];
    camera.distance = Math.max(camera.distance, (MARGIN * Math.max(sideways, upwards)) / slope - dot(corner, f.ahead));
  }
  camera.eye = add(middle, f.ahead, -camera.distance);
}

// The box's corner that is farthest away, and the nearest point of the box, decide what depth must tell apart.
function depths() {
  let far = 0, near = 0;
  for (let i = 0; i < 3; i++) {
    far += Math.max(Math.abs(camera.eye[i] - about.low[i]), Math.abs(camera.eye[i] - about.high[i])) ** 2;
    near += Math.max(about.low[i] - camera.eye[i], camera.eye[i] - about.high[i], 0) ** 2;
  }
  far = Math.sqrt(far) * 1.001;
  return [Math.max(Math.sqrt(near) * 0.5, far * 1e-3), far];
}

// From the world to the clip space of WebGL, column by column. Depth is as if all were `farther` times its distance farther
// away; it stays where it is on the screen.
function clipFromWorld(aspect, farther) {
  const { right, up, ahead } = frame();
  const [near, far] = depths();
  const focal = 1 / Math.tan((camera.fov * DEGREE) / 2);
  const rows = [
    right.map((x) => (x * focal) / aspect),
    up.map((x) => x * focal),
    ahead.map((x) => (x * (far + near)) / (far - near)),
    ahead,
  ];
  const moved = rows.map((row) => -dot(row, camera.eye));
  moved[2] -= (2 * far * near) / (far - near) / (1 + farther);
  return new Float32Array([0, 1, 2].flatMap((i) => rows.map((row) => row[i])).concat(moved));
}

// The nearest front that the ray through a place of the window meets: where, and how much light falls on it.
function pick(x, y, aspect) {
  const f = frame();
  const slope = Math.tan((camera.fov * DEGREE) / 2);
  const ray = add(add(f.ahead, f.right, x * slope * aspect), f.up, y * slope);
  const { positions, indices, irradiance } = tables;
  const at = (i) => [positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]];
  let best = Infinity, light = 0;
  for (let i = 0; i < indices.length; i += 3) {
    const a = at(indices[i]);
    const u = add(at(indices[i + 1]), a, -1), v = add(at(indices[i + 2]), a, -1);
    const p = cross(ray, v);
    const area = dot(u, p);
    if (area <= 0) continue;
    const s = add(camera.eye, a, -1);
    const b = dot(s, p) / area;
    if (b < 0 || b > 1) continue;
    const q = cross(s, u);
    const c = dot(ray, q) / area;
    const t = dot(v, q) / area;
    if (c < 0 || b + c > 1 || t <= 0 || t >= best) continue;
    best = t;
    const [ea, eb, ec] = [0, 1, 2].map((k) => irradiance[indices[i + k]]);
    light = ea + b * (eb - ea) + c * (ec - ea);
  }
  return best < Infinity ? { point: add(camera.eye, ray, best), irradiance: light } : null;
}
