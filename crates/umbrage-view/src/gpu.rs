//! The graphics device: a processor for graphics, or a driver that does its work on the main one.

use wgpu::{Adapter, Backends, DeviceDescriptor, Instance, InstanceDescriptor, Limits, PowerPreference};

/// Why nothing can be drawn.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// There is no graphics driver at all.
    #[error(
        "no graphics driver was found ({0}): install one; on Debian, mesa-vulkan-drivers or libgl1-mesa-dri draw without \
         a graphics card"
    )]
    NoAdapter(#[from] wgpu::RequestAdapterError),
    /// The driver refuses.
    #[error("the graphics driver refuses to work: {0}")]
    NoDevice(#[from] wgpu::RequestDeviceError),
}

/// A device without a window.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) kind: wgpu::DeviceType,
    /// What it is called, and how it is reached.
    pub name: String,
}

impl Gpu {
    /// The best device that works without a window. `WGPU_BACKEND=vulkan`, `gl`, ... chooses how it is reached.
    ///
    /// # Errors
    /// [`GpuError`] where there is none.
    pub fn headless() -> Result<Self, GpuError> {
        match Backends::from_env() {
            Some(backends) => Self::reached_by(backends),
            // OpenGL comes last: asking for it may start the system's display.
            None => Self::reached_by(Backends::PRIMARY).or_else(|_| Self::reached_by(Backends::GL)),
        }
    }

    /// The best device that works without a window and is reached in one of these ways.
    ///
    /// # Errors
    /// [`GpuError`] where there is none.
    pub fn reached_by(backends: Backends) -> Result<Self, GpuError> {
        let instance = Instance::new(&InstanceDescriptor { backends, ..InstanceDescriptor::default() });
        let power_preference = PowerPreference::HighPerformance;
        let options = wgpu::RequestAdapterOptions { power_preference, ..wgpu::RequestAdapterOptions::default() };
        let adapter = pollster::block_on(instance.request_adapter(&options))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&device_descriptor(&adapter)))?;
        let info = adapter.get_info();
        Ok(Self { device, queue, kind: info.device_type, name: format!("{} ({})", info.name, info.backend) })
    }
}

/// What is asked of a device: no more than what even OpenGL ES 3.0 has, but textures and buffers as large as it can.
pub(crate) fn device_descriptor(adapter: &Adapter) -> DeviceDescriptor<'static> {
    let can = adapter.limits();
    let required_limits =
        Limits { max_buffer_size: can.max_buffer_size, ..Limits::downlevel_webgl2_defaults().using_resolution(can) };
    DeviceDescriptor { label: Some("umbrage-view"), required_limits, ..DeviceDescriptor::default() }
}
