//! A texel in one picture: its finest level from four sides and from above, and every level from the front.
//!
//! The ordinary cone tracer draws it, one copy on a flat square, lit from the upper left of whoever looks.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use font8x8::UnicodeFonts;
use glam::{Quat, Vec3};
use pelage_skin::{SkinOptions, extrude, surface};
use pelage_texel::Texel;
use pelage_tracer::{Coat, Description, Film, Light, Lod, Pixel, Rect, RenderError, Scene, Settings, render};

use crate::compose::{Backdrop, over};
use crate::error::{Error, Field};
use crate::output::Display;
use crate::staging::{self, View};

/// One of the pictures on a sheet.
struct Panel {
    label: String,
    level: u32,
    /// Degrees, as in [`View`].
    azimuth: f32,
    elevation: f32,
}

/// Panels in a row.
const COLUMNS: u32 = 5;
/// Height of a line of text, in pixels.
const LINE: u32 = 12;
/// What stands behind, as the screen shows it; and the text.
const PAPER: Vec3 = Vec3::splat(0.55);
const INK: Vec3 = Vec3::ZERO;

/// Draws the sheet in panels of `side` pixels, at least 16. `progress` is told the fraction done, and may stop it.
///
/// # Errors
/// [`RenderError::Cancelled`] where it was stopped, with the panels that are done; a texel that no scene can hold.
pub fn contact_sheet(
    texel: &Arc<Texel>,
    side: u32,
    display: &Display,
    progress: &(dyn Fn(f32) -> ControlFlow<()> + Sync),
) -> Result<Film, Error> {
    let side = side.max(16);
    let panels = panels(texel);
    let rows = (panels.len() as u32).div_ceil(COLUMNS);
    let size = [COLUMNS * side, rows * (side + LINE)];
    let mut sheet = Film::new(size, Rect::whole(size));
    let paper = Pixel { color: display.radiance_of(PAPER), alpha: 1.0, ..Pixel::EMPTY };
    sheet.pixels.fill(paper);
    let count = panels.len() as f32;
    for (i, panel) in (0..).zip(&panels) {
        let corner = [i % COLUMNS * side, i / COLUMNS * (side + LINE)];
        write(&mut sheet, corner, side, &panel.label, display.radiance_of(INK));
        let drawn = draw(texel, panel, side, display, &|f| progress((i as f32 + f) / count));
        let film = drawn.map_err(|error| match error {
            Error::Render(RenderError::Cancelled { done, total, .. }) => {
                RenderError::Cancelled { done, total, film: Box::new(sheet.clone()) }.into()
            }
            error => error,
        })?;
        let window = Rect { x: corner[0], y: corner[1] + LINE, width: side, height: side };
        sheet.paste(window, &film.pixels);
    }
    Ok(sheet)
}

fn panels(texel: &Texel) -> Vec<Panel> {
    let level = texel.depth();
    let finest = [("front", 0.0), ("right", 90.0), ("back", 180.0), ("left", 270.0)];
    let sides = finest.map(|(label, azimuth)| Panel { label: label.into(), level, azimuth, elevation: 12.0 });
    let top = Panel { label: "top".into(), level, azimuth: 0.0, elevation: 89.9 };
    let levels = (0..texel.levels().len() as u32).map(|level| Panel {
        label: format!("level {level}: {}", 1_u64 << level),
        level,
        azimuth: 0.0,
        elevation: 12.0,
    });
    sides.into_iter().chain([top]).chain(levels).collect()
}

fn draw(
    texel: &Arc<Texel>,
    panel: &Panel,
    side: u32,
    display: &Display,
    progress: &(dyn Fn(f32) -> ControlFlow<()> + Sync),
) -> Result<Film, Error> {
    let options = SkinOptions { tiling: Some(1.0), ..SkinOptions::new(1.0) };
    let skin = extrude(&surface::plane(1.0, 1, 1), &|_| true, &options).map_err(|source| Error::Skin {
        field: Field::whole(Path::new("the square under the texel")),
        source: Box::new(source),
    })?;
    let mut sun = staging::sun();
    if let Light::Directional { direction, .. } = &mut sun {
        *direction = Quat::from_rotation_y(panel.azimuth.to_radians()) * *direction;
    }
    let scene = Scene::new(Description {
        meshes: Vec::new(),
        coats: vec![Coat { skin, texels: texel.clone().into(), tint: Vec3::ONE, wears_material: false }],
        materials: Vec::new(),
        textures: Vec::new(),
        lights: vec![sun],
        environment: staging::sky(),
    })?;
    let cube = [Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 1.0, 0.5)];
    let view = View { azimuth: panel.azimuth, elevation: panel.elevation, zoom: 1.0, fov: 12.0 };
    let camera = staging::camera(cube, &view, 1.0);
    let settings = Settings { size: [side; 2], lod: Lod::Level(panel.level), ..Settings::default() };
    let film = render(&scene, &camera, &settings, &|p| progress(p.done as f32 / p.total as f32))?;
    Ok(over(&film, &camera, &Backdrop::Color(display.radiance_of(PAPER))))
}

/// Writes a line of text, 8 pixels a letter, as much of it as is `width` pixels wide.
fn write(film: &mut Film, [x, y]: [u32; 2], width: u32, text: &str, ink: Vec3) {
    const MARGIN: u32 = 2;
    let letters = text.chars().take((width.saturating_sub(MARGIN) / 8) as usize);
    for (column, letter) in (0..).zip(letters) {
        let rows = font8x8::BASIC_FONTS.get(letter).unwrap_or_default();
        for (row, bits) in (0..).zip(rows) {
            for bit in (0..8).filter(|bit| bits >> bit & 1 != 0) {
                let at = Rect { x: x + MARGIN + 8 * column + bit, y: y + MARGIN + row, width: 1, height: 1 };
                film.paste(at, &[Pixel { color: ink, alpha: 1.0, ..Pixel::EMPTY }]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use pelage_texel::{BuildOptions, Spheres, build};

    use super::*;

    #[test]
    fn every_level_has_its_panel() {
        let options = BuildOptions { depth: 3, points: 16, ..BuildOptions::preview() };
        let texel = Arc::new(build("balls", Spheres::lattice(), &options, &|_| ()).expect("a texel"));
        let display = Display::default();
        let sheet = contact_sheet(&texel, 24, &display, &|_| ControlFlow::Continue(())).expect("a sheet");
        // Five views and four levels, in two rows.
        assert_eq!(sheet.size, [5 * 24, 2 * (24 + 12)]);
        let paper = display.radiance_of(PAPER);
        let shows = |column: u32, row: u32| {
            let pixels = (0..24 * 24).map(|i| (24 * column + i % 24, 36 * row + 12 + i / 24));
            let drawn =
                |&(x, y): &(u32, u32)| sheet.get(x, y).is_some_and(|p| (p.color - paper).length() > 0.05);
            pixels.filter(drawn).count()
        };
        for panel in 0..9 {
            let drawn = shows(panel % 5, panel / 5);
            assert!((100..500).contains(&drawn), "panel {panel}: {drawn} pixels");
        }
        assert_eq!(shows(4, 1), 0);
    }
}
