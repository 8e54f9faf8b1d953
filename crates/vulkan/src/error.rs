use ash::vk;

/// Failures of Vulkan, one sentence each for the user.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VulkanError {
    /// There is no Vulkan loader on this machine.
    #[error(
        "there is no Vulkan loader on this machine (Debian and Ubuntu: apt install libvulkan1; Fedora: dnf install vulkan-loader)"
    )]
    NoLoader,
    /// The loader found no driver.
    #[error(
        "no Vulkan driver is installed: install your graphics card's, or Mesa's (Debian and Ubuntu: apt install mesa-vulkan-drivers)"
    )]
    NoDriver,
    /// No window can be drawn into.
    #[error(
        "no Vulkan driver on this machine can draw into a window: install your graphics card's, or Mesa's (Debian and Ubuntu: apt install mesa-vulkan-drivers); `raggio render` works without"
    )]
    NoWindows,
    /// Validation was asked for and cannot be had.
    #[error(
        "RAGGIO_VALIDATE=1 needs the Vulkan validation layers (Debian and Ubuntu: apt install vulkan-validationlayers)"
    )]
    NoValidationLayers,
    /// The device lacks what the kernels need.
    #[error("{name} lacks {missing}, which the kernels need")]
    Unfit {
        /// Name of the device.
        name: String,
        /// Features that the device lacks.
        missing: String,
    },
    /// The driver fails to compile a kernel.
    #[error(
        "{name}'s driver, {driver}, cannot compile the kernels ({result}): a newer one may, and `--device cpu` needs none"
    )]
    Kernels {
        /// Name of the device.
        name: String,
        /// Name and version of the driver.
        driver: String,
        /// Answer of the driver.
        result: vk::Result,
    },
    /// A buffer is larger than the device can bind or allocate.
    #[error("{what} needs {needed} bytes in one buffer, and {name} can take {limit} there")]
    TooLarge {
        /// Name of what was to be stored.
        what: String,
        /// Name of the device.
        name: String,
        /// Size of what was to be stored, in bytes.
        needed: u64,
        /// Most bytes that the device takes.
        limit: u64,
    },
    /// A structure that hardware is to trace rays by has more parts than the device takes.
    #[error("{what} has {parts} parts, and {name} traces {limit} by hardware")]
    TooManyParts {
        /// Name of the structure.
        what: String,
        /// Name of the device.
        name: String,
        /// Number of parts.
        parts: u64,
        /// Most parts that the device takes.
        limit: u64,
    },
    /// An image has more pixels on a side than the device can draw.
    #[error("{name} can draw {limit} pixels on a side, and a picture of {width}x{height} is larger")]
    ImageTooLarge {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Name of the device.
        name: String,
        /// Most pixels on a side.
        limit: u32,
    },
    /// Contents of a buffer that take more memory than is free.
    #[error("{what} needs {:.2} GiB of memory on {name}, which has {:.2} GiB free", gib(*needed), gib(*free))]
    NoRoom {
        /// Name of what was to be stored.
        what: String,
        /// Name of the device.
        name: String,
        /// Bytes that are needed.
        needed: u64,
        /// Bytes that are free.
        free: u64,
    },
    /// The device or the host has too little memory left for the named purpose.
    #[error("out of memory on the device: {0}")]
    OutOfMemory(String),
    /// The panels over the picture cannot be drawn.
    #[error("cannot draw the panels: {0}")]
    Panels(String),
    /// The driver reset the device or it went away.
    #[error("the device was lost: the driver reset it, or it went away")]
    DeviceLost,
    /// The window system took back what was drawn into.
    #[error("the window can no longer be drawn into")]
    SurfaceLost,
    /// CUDA cannot be handed memory of the device.
    #[error("CUDA cannot be used: {0}")]
    Cuda(String),
    /// Any other failure of a Vulkan call.
    #[error("{call} failed: {result}")]
    Call {
        /// Name of the call.
        call: &'static str,
        /// Result of the call.
        result: vk::Result,
    },
}

fn gib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 30)
}

/// Names the Vulkan call in the error of a result.
pub(crate) trait During<T> {
    fn during(self, call: &'static str) -> Result<T, VulkanError>;
}

impl<T> During<T> for Result<T, vk::Result> {
    fn during(self, call: &'static str) -> Result<T, VulkanError> {
        self.map_err(|result| VulkanError::of(call, result))
    }
}

impl VulkanError {
    /// Error of a call that has ended with `result`.
    pub(crate) fn of(call: &'static str, result: vk::Result) -> Self {
        match result {
            vk::Result::ERROR_DEVICE_LOST => Self::DeviceLost,
            vk::Result::ERROR_SURFACE_LOST_KHR => Self::SurfaceLost,
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => Self::NoDriver,
            vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
                Self::OutOfMemory(call.into())
            }
            result => Self::Call { call, result },
        }
    }
}
