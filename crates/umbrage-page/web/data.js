// The scene: facts as JSON, tables as one block of bytes in Base64.
//
// Positions are relative to the file's origin, in metres, so that large coordinates keep their precision; `light` is what
// base colour and texture are multiplied with, exposed with the file's k, not cut off at white; `irradiance` is its
// luminance in the file's unit.

const about = JSON.parse(document.getElementById("about").textContent);

function bytesOf(base64) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(base64);
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

const tables = (() => {
  const element = document.getElementById("data");
  const bytes = bytesOf(element.textContent);
  // The text is as large as the tables, and is needed no more.
  element.remove();
  let at = 0;
  const take = (Type, count) => {
    const table = new Type(bytes.buffer, at, count);
    at += table.byteLength;
    return table;
  };
  return {
    positions: take(Float32Array, 3 * about.vertices),
    light: take(Float32Array, 3 * about.vertices),
    irradiance: take(Float32Array, about.vertices),
    uvs: about.textures.length ? take(Float32Array, 2 * about.vertices) : null,
    indices: take(Uint32Array, 3 * about.triangles),
    images: about.textures.map((texture) => take(Uint8Array, texture.bytes)),
  };
})();
