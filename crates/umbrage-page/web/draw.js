// Drawing: one vertex array for surfaces, another without shared vertices for triangles, made when it is first needed.
//
// Where one thing stands on another, the covered area is black, and its border is as near as what covers it. So that no
// black comes through there, triangles without any light are drawn last, and as if they were a little farther away: by a
// share of their distance, two steps of a depth of 24 bits; and by what their depth changes over part of a pixel: corners are
// rounded to a sixteenth of one at worst, so that two lines are 0.09 pixels apart at most. No more than that, or what stands
// behind a black wall comes through where it meets the wall.
const DARK_FARTHER = 1e-4;
const DARK_FARTHER_PX = 0.125;

const canvas = document.getElementById("view");
const shown = { show: 0, filmic: false, exposure: 1, wire: false, scaleEnd: about.scaleEnd };

function fail(text) {
  const failure = document.getElementById("failure");
  failure.textContent = text;
  failure.hidden = false;
}

const gl = canvas.getContext("webgl2", { alpha: false, antialias: true });
let scene = null;

function compiled(type, text) {
  const shader = gl.createShader(type);
  gl.shaderSource(shader, text);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
    throw new Error(gl.getShaderInfoLog(shader));
  }
  return shader;
}

function vertexArray(positions, light, irradiance, uvs) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  [[positions, 3], [light, 3], [irradiance, 1], [uvs, 2]].forEach(([table, width], location) => {
    if (!table) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, table, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, width, gl.FLOAT, false, 0, 0);
  });
  return array;
}

function unshared(table, width) {
  if (!table) return null;
  const { indices } = tables;
  const flat = new Float32Array(width * indices.length);
  for (let i = 0; i < indices.length; i++) {
    for (let k = 0; k < width; k++) flat[width * i + k] = table[width * indices[i] + k];
  }
  return flat;
}

function wires() {
  const { positions, light, irradiance, uvs } = tables;
  return vertexArray(unshared(positions, 3), unshared(light, 3), unshared(irradiance, 1), unshared(uvs, 2));
}

// A texture is white until its image is decoded.
function texture(number) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4).fill(255));
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  const asIs = { premultiplyAlpha: "none", colorSpaceConversion: "none" };
  createImageBitmap(new Blob([tables.images[number]]), asIs).then((image) => {
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
    gl.generateMipmap(gl.TEXTURE_2D);
    const [s, t] = about.textures[number].wrap.map((name) => gl[name]);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, s);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, t);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    const sharper = gl.getExtension("EXT_texture_filter_anisotropic");
    if (sharper) gl.texParameterf(gl.TEXTURE_2D, sharper.TEXTURE_MAX_ANISOTROPY_EXT, 8);
    redraw();
  }, () => fail("A texture of this scene could not be decoded."));
  return made;
}

function prepare() {
  const program = gl.createProgram();
  gl.attachShader(program, compiled(gl.VERTEX_SHADER, VERTEX_SHADER));
  gl.attachShader(program, compiled(gl.FRAGMENT_SHADER, FRAGMENT_SHADER));
  gl.linkProgram(program);
  gl.useProgram(program);
  const uniforms = {};
  for (const name of ["clipFromWorld", "base", "textured", "cutoff", "show", "filmic", "exposure", "scaleEnd", "wire"]) {
    uniforms[name] = gl.getUniformLocation(program, name);
  }
  const surfaces = vertexArray(tables.positions, tables.light, tables.irradiance, tables.uvs);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, tables.indices, gl.STATIC_DRAW);
  scene = { uniforms, surfaces, wires: null, textures: about.textures.map((_, number) => texture(number)) };
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.CULL_FACE);
  gl.polygonOffset(DARK_FARTHER_PX, 0);
  gl.clearColor(...about.background, 1);
}

function draw() {
  if (gl.isContextLost()) return;
  const { uniforms } = scene;
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.uniform1i(uniforms.show, shown.show);
  gl.uniform1i(uniforms.filmic, shown.filmic ? 1 : 0);
  gl.uniform1f(uniforms.exposure, shown.exposure);
  gl.uniform1f(uniforms.scaleEnd, shown.scaleEnd);
  gl.uniform1i(uniforms.wire, shown.wire ? 1 : 0);
  if (shown.wire) scene.wires ??= wires();
  gl.bindVertexArray(shown.wire ? scene.wires : scene.surfaces);
  for (const dark of [false, true]) {
    if (dark) gl.enable(gl.POLYGON_OFFSET_FILL);
    else gl.disable(gl.POLYGON_OFFSET_FILL);
    const matrix = clipFromWorld(canvas.width / canvas.height, dark ? DARK_FARTHER : 0);
    gl.uniformMatrix4fv(uniforms.clipFromWorld, false, matrix);
    for (const { first, lit, dark: unlit, base, texture: number, cutoff } of about.materials) {
      const [begin, count] = dark ? [first + lit, unlit] : [first, lit];
      if (count === 0) continue;
      gl.uniform3fv(uniforms.base, base);
      gl.uniform1i(uniforms.textured, number === null ? 0 : 1);
      gl.uniform1f(uniforms.cutoff, cutoff);
      if (number !== null) gl.bindTexture(gl.TEXTURE_2D, scene.textures[number]);
      if (shown.wire) gl.drawArrays(gl.TRIANGLES, begin, count);
      else gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * begin);
    }
  }
}

let waiting = false;
function redraw() {
  if (waiting || !scene) return;
  waiting = true;
  requestAnimationFrame((now) => {
    waiting = false;
    const walking = walk(now);
    draw();
    document.documentElement.dataset.drawn = "yes";
    if (walking) redraw();
  });
}

function resize() {
  const density = window.devicePixelRatio || 1;
  canvas.width = Math.max(1, Math.round(canvas.clientWidth * density));
  canvas.height = Math.max(1, Math.round(canvas.clientHeight * density));
  redraw();
}
