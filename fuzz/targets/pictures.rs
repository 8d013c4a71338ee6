//! Pictures inside a glTF: the bytes are the image of a texture, in each of the formats that are told by their beginning.
#![no_main]

use umbrage_formats::{ReadOptions, read_scene_bytes};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut bin: Vec<u8> = Vec::new();
    let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    floats.iter().for_each(|x| bin.extend(x.to_le_bytes()));
    let image = bin.len();
    bin.extend(bytes);
    bin.resize(bin.len().next_multiple_of(4), 0);
    let length = bytes.len();
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},{{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}},{{"buffer":0,"byteOffset":{image},"byteLength":{length}}}],
        "buffers":[{{"byteLength":{}}}],"images":[{{"bufferView":2}}],"textures":[{{"source":0}}],
        "materials":[{{"alphaMode":"BLEND","pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}]}}"#,
        bin.len()
    );
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend(((28 + json.len() + bin.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &bin)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    // Whatever the picture, the scene is read: a picture that cannot be had is a warning.
    let (scene, _) = read_scene_bytes("no/such/folder/fuzz.glb", glb, &ReadOptions::default()).expect("a scene");
    assert!(scene.materials.iter().all(|m| m.reflectance.is_finite() && m.reflectance.max_element() <= 0.9));
});
