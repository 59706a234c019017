//! Structs that exist on both sides: declared once, in Rust, and rendered to WGSL.
//!
//! A test holds every struct against naga's offsets and reads a pattern back on the device.

/// A struct that exists on both sides.
pub trait GpuStruct: bytemuck::Pod {
    /// Its name, the same in WGSL.
    const NAME: &'static str;
    /// Its declaration in WGSL.
    const WGSL: &'static str;
    /// WGSL type of every field.
    const TYPES: &'static [&'static str];
    /// Name and offset of every field on the Rust side.
    fn offsets() -> Vec<(&'static str, usize)>;
}

/// Words of padding after so many words: sizes are multiples of 16 bytes on the device.
pub(crate) const fn padding(words: usize) -> usize {
    (4 - words % 4) % 4
}

/// Declare a struct once for both sides. Field types are f32, u32, Vec3, Vec4, UVec4, Bands and arrays of these by an
/// alias; a Vec3 is followed by a scalar, so that both sides agree on the padding. Where the size depends on the number of bands,
/// `words` is the number of words of 4 bytes, and Rust pads as WGSL does.
macro_rules! gpu_struct {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $ty:ident,)* } $(words $words:expr)?) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name {
            $($(#[$field_meta])* pub $field: $ty,)*
            $(
                /// Padding.
                pub pad: [u32; $crate::packed::gpu_struct::padding($words)],
            )?
        }

        impl $crate::packed::gpu_struct::GpuStruct for $name {
            const NAME: &'static str = stringify!($name);
            const WGSL: &'static str = concat!(
                "struct ", stringify!($name), " {\n",
                $("    ", stringify!($field), ": ", stringify!($ty), ",\n",)*
                "}\n"
            );
            const TYPES: &'static [&'static str] = &[$(stringify!($ty),)*];
            fn offsets() -> Vec<(&'static str, usize)> {
                vec![$((stringify!($field), std::mem::offset_of!($name, $field)),)*]
            }
        }
    };
}
pub(crate) use gpu_struct;

/// The WGSL names of the Rust types that fields have; [`crate::spectrum::wgsl`] has that of bands.
pub const ALIASES: &str =
    "alias Vec3 = vec3<f32>;\nalias Vec4 = vec4<f32>;\nalias Table = array<vec4<u32>, 16>;\n";

/// Sixty-four words in a uniform buffer.
pub type Table = [[u32; 4]; 16];
