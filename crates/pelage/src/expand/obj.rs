//! Wavefront OBJ, with the widespread extension of a colour after each position.

use std::io::{self, Write};

use pelage_tracer::reference::Expansion;

use super::each;
use crate::output::{Display, Tone};

pub(super) const HEADER: &str = "# Written by pelage: metres, +Y up, sRGB colours.\n";

/// Bytes of a triangle, at most: three lines of three numbers of 15 characters and three of 6, and a face.
pub(super) const TRIANGLE: u64 = 3 * (2 + 3 * 16 + 3 * 7) + 10;

pub(super) fn write(
    expansion: &Expansion,
    file: &mut dyn Write,
    tell: &mut dyn FnMut() -> io::Result<()>,
) -> io::Result<()> {
    file.write_all(HEADER.as_bytes())?;
    let display = Display { exposure: 1.0, tone: Tone::None };
    for (i, part) in expansion.parts().iter().enumerate().filter(|(_, part)| part.triangles > 0) {
        // A name is one word to many readers.
        let name: String =
            part.name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).take(48).collect();
        writeln!(file, "o {name}")?;
        each(expansion, i, file, tell, &mut |file, triangle| {
            for (corner, color) in triangle.corners.iter().zip(triangle.colors) {
                let [r, g, b] = display.srgb(color).map(|x| f32::from(x) / 255.0);
                writeln!(file, "v {:e} {:e} {:e} {r:.4} {g:.4} {b:.4}", corner.x, corner.y, corner.z)?;
            }
            // The last three vertices, whatever their numbers.
            file.write_all(b"f -3 -2 -1\n")
        })?;
    }
    Ok(())
}
