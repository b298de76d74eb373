//! Binary little-endian PLY. [Turk94]

use std::io::{self, Write};

use pelage_tracer::reference::Expansion;

use super::each;
use crate::output::{Display, Tone};

/// Bytes of a vertex: position, normal, colour.
const VERTEX: usize = 12 + 12 + 3;

/// Bytes of a triangle: three vertices of its own, and a face of a count and three indices.
pub(super) const TRIANGLE: u64 = 3 * VERTEX as u64 + 13;

pub(super) fn header(triangles: u64) -> String {
    let vertices = 3 * triangles;
    format!(
        "ply\nformat binary_little_endian 1.0\ncomment written by pelage; metres, +Y up, sRGB\n\
         element vertex {vertices}\n\
         property float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face {triangles}\nproperty list uchar uint vertex_indices\nend_header\n"
    )
}

pub(super) fn write(
    expansion: &Expansion,
    file: &mut dyn Write,
    tell: &mut dyn FnMut() -> io::Result<()>,
) -> io::Result<()> {
    let triangles = expansion.triangles();
    file.write_all(header(triangles).as_bytes())?;
    let display = Display { exposure: 1.0, tone: Tone::None };
    for part in 0..expansion.parts().len() {
        each(expansion, part, file, tell, &mut |file, triangle| {
            for i in 0..3 {
                let numbers = [triangle.corners[i], triangle.normals[i]];
                for x in numbers.iter().flat_map(|v| v.to_array()) {
                    file.write_all(&x.to_le_bytes())?;
                }
                file.write_all(&display.srgb(triangle.colors[i]))?;
            }
            Ok(())
        })?;
    }
    for triangle in 0..triangles {
        file.write_all(&[3])?;
        for corner in 0..3 {
            // The size that the format can hold was asked for before.
            file.write_all(&((3 * triangle + corner) as u32).to_le_bytes())?;
        }
    }
    Ok(())
}
