//! What a picture shows besides its colour, as further channels of an EXR file or in false colours.

use glam::{Vec3, Vec4};
use pelage_tracer::{Aovs, Film, Pixel};

/// One of the things that a pixel shows ([`Aovs`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aov {
    /// The number of the box: channel `patch`, whole numbers of 32 bits, [`Aovs::NO_PATCH`] for none.
    Patch,
    /// How much the texel is stretched: channel `stretch`, 1 for not at all, 0 without a box.
    Stretch,
    /// Which way the surface faces: channels `normal.X`, `normal.Y` and `normal.Z`, scene space.
    Normal,
}

impl Aov {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Patch, Self::Stretch, Self::Normal];

    /// Its name, that of its channel or of the layer of its channels.
    pub fn name(self) -> &'static str {
        match self {
            Self::Patch => "patch",
            Self::Stretch => "stretch",
            Self::Normal => "normal",
        }
    }
}

/// A film of one of them to look at: a colour of its own for each box; green for no stretch over yellow to red for 2
/// and more; normals from −1 to 1 as colours from 0 to 1. As a screen shows it without a tone curve.
pub fn false_color(aovs: &Aovs, which: Aov) -> Film {
    let color = |i: usize| -> Vec4 {
        match which {
            Aov::Patch if aovs.patch[i] == Aovs::NO_PATCH => Vec4::ZERO,
            Aov::Patch => hue(aovs.patch[i]).extend(1.0),
            Aov::Stretch if aovs.stretch[i] == 0.0 => Vec4::ZERO,
            Aov::Stretch => {
                let x = (2.0 * (aovs.stretch[i] - 1.0)).clamp(0.0, 2.0);
                Vec4::new(x.min(1.0), (2.0 - x).min(1.0), 0.0, 1.0)
            }
            Aov::Normal if aovs.normal[i] == Vec3::ZERO => Vec4::ZERO,
            Aov::Normal => (0.5 * aovs.normal[i] + 0.5).extend(1.0),
        }
    };
    let pixel = |i: usize| {
        let color = color(i);
        Pixel { color: color.truncate(), alpha: color.w, depth: f32::INFINITY }
    };
    Film { size: aovs.size, window: aovs.window, pixels: (0..aovs.patch.len()).map(pixel).collect() }
}

/// A colour that differs much from those of the numbers before and after: hues by the golden ratio.
fn hue(number: u32) -> Vec3 {
    let turn = (f64::from(number) * 0.618_033_988_749_895).fract() as f32;
    let part = |shift: f32| (6.0 * (turn + shift).fract() - 3.0).abs() - 1.0;
    Vec3::new(part(0.0), part(2.0 / 3.0), part(1.0 / 3.0)).clamp(Vec3::splat(0.05), Vec3::splat(0.9))
}

#[cfg(test)]
mod tests {
    use pelage_tracer::Rect;

    use super::*;

    #[test]
    fn false_colours() {
        let aovs = Aovs {
            size: [4, 1],
            window: Rect::whole([4, 1]),
            patch: vec![0, 1, 7, Aovs::NO_PATCH],
            stretch: vec![1.0, 1.5, 3.0, 0.0],
            normal: vec![Vec3::Y, Vec3::X, Vec3::Z, Vec3::ZERO],
        };
        let colors = |which| false_color(&aovs, which).pixels.iter().map(|p| p.color).collect::<Vec<_>>();
        assert_eq!(colors(Aov::Stretch), [Vec3::Y, Vec3::new(1.0, 1.0, 0.0), Vec3::X, Vec3::ZERO]);
        assert_eq!(colors(Aov::Normal)[..2], [Vec3::new(0.5, 1.0, 0.5), Vec3::new(1.0, 0.5, 0.5)]);
        let of_patches = colors(Aov::Patch);
        assert!(of_patches[0].distance(of_patches[1]) > 0.5 && of_patches[3] == Vec3::ZERO);
    }
}
