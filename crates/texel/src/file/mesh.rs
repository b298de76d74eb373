//! The triangles that a texel was made from, as the bytes of a file.
//!
//! ```text
//! byte 0  triangles  u32
//!      4  specular   f32
//!      8  roughness  f32
//!     12  corners    9 × f32 a triangle
//!         colours    3 × f32 a triangle
//! ```
//!
//! Corners and colours are tables whose records stand in [`planes`](super::planes).

use glam::Vec3;

use super::planes::{Planes, write};
use crate::Geometry;

/// The bytes of triangles.
pub(super) fn encode(geometry: &Geometry) -> Vec<u8> {
    let mut out = (geometry.triangles.len() as u32).to_le_bytes().to_vec();
    out.extend(geometry.specular.to_le_bytes());
    out.extend(geometry.roughness.to_le_bytes());
    write(&mut out, geometry.triangles.iter().map(|corners| floats::<36>(corners)));
    write(&mut out, geometry.colors.iter().map(|&color| floats::<12>(&[color])));
    out
}

/// The triangles that `bytes` list, or what is wrong with them.
pub(super) fn decode(bytes: &[u8]) -> Result<Geometry, &'static str> {
    let mut planes = Planes(bytes);
    let all = |planes: &mut Planes| {
        let count = planes.u32()? as usize;
        let [specular, roughness] = [planes.u32()?, planes.u32()?].map(f32::from_bits);
        let triangles = planes.read::<36>(count)?.map(|record| {
            let corner = |i: usize| vector(std::array::from_fn(|byte| record[12 * i + byte]));
            [corner(0), corner(1), corner(2)]
        });
        let colors = planes.read::<12>(count)?.map(vector);
        Some(Geometry { triangles: triangles.collect(), colors: colors.collect(), specular, roughness })
    };
    let geometry = all(&mut planes).ok_or("is shorter than its count says")?;
    if planes.0.is_empty() { Ok(geometry) } else { Err("is longer than its count says") }
}

/// Vectors as the bytes of their components.
fn floats<const N: usize>(vectors: &[Vec3]) -> [u8; N] {
    let mut bytes = [0; N];
    let components = vectors.iter().flat_map(|v| v.to_array());
    bytes.chunks_exact_mut(4).zip(components).for_each(|(bytes, x)| bytes.copy_from_slice(&x.to_le_bytes()));
    bytes
}

fn vector(bytes: [u8; 12]) -> Vec3 {
    let component = |i: usize| f32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * i + byte]));
    Vec3::new(component(0), component(1), component(2))
}
