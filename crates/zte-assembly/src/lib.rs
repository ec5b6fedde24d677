//! Zero-thickness interface elements: interpolation and integration operators, force and tangent assembly, dissipation flux.
pub mod mesh;
