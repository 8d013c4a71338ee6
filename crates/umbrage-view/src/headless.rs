//! A picture of what the window would show, without a window.

use anyhow::{bail, ensure};
use umbrage::progress::Progress;
use umbrage_picture::Picture;

use crate::draw::{Frame, Renderer, Show};
use crate::gpu::Gpu;
use crate::lens::Lens;
use crate::load::load;
use crate::marks::Marker;
use crate::options::{ViewOptions, first_look, first_scale};
use crate::targets::Targets;
use crate::upload::UploadedMarks;

/// Opens a file, bakes it if it is a scene, and draws it with `gpu`.
///
/// # Errors
/// Where the file cannot be opened, or not drawn in the way that is asked for.
pub fn screenshot(options: &ViewOptions, gpu: Gpu) -> anyhow::Result<Picture> {
    let loaded = load(&options.job, Progress::silent(), &|_| {})?;
    let path = options.job.path.display();
    if options.lines.needs_bake() && loaded.baked.is_none() {
        bail!("{path}: a baked file does not hold shadow edges and patches: give the scene that it was baked from");
    }
    let renderer = Renderer::new(gpu.device, gpu.queue, gpu.kind);
    let size = [options.size.width, options.size.height].map(|side| side as u32);
    let targets = Targets::new(&renderer, size);
    ensure!(targets.size_px == size, "{} x {} pixels are more than this graphics driver can draw", size[0], size[1]);

    let scene = renderer.upload(&loaded.tables)?;
    if options.lines.wireframe {
        scene.wires?;
    }
    let (origin_m, bounds_m) = (loaded.tables.origin_m, loaded.tables.bounds_m);
    let camera = options.camera.choose(&loaded.shown, options.size)?;
    let lens = Lens::new(&camera, targets.aspect(), origin_m, bounds_m)?;
    let mut marks = Vec::new();
    if let Some(baked) = &loaded.baked {
        let marker = Marker { meshed: &baked.meshed, origin_m };
        marks.extend(options.lines.patches.map(|level| marker.patches(level)));
        marks.extend(options.lines.segments.then(|| marker.d_segments([true; 3])));
    }
    let marks: Vec<_> = marks.iter().map(|marks| UploadedMarks::new(&renderer.device, marks)).collect();
    let look = first_look(&options.look, options.lines, &loaded.shown.file);
    renderer.draw(
        &Frame { lens, look, dither: false },
        &targets,
        &loaded.tables,
        &scene,
        &marks.iter().collect::<Vec<_>>(),
    );
    let mut picture = targets.picture(&renderer)?;
    if look.show == Show::Irradiance {
        let (unit, end) = first_scale(&options.look, &loaded.shown.file);
        unit.scale(end).draw(&mut picture);
    }
    Ok(picture)
}
