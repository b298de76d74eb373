//! Whether the numbers of a described scene make sense: what can be told without reading a mesh file.

use std::ops::RangeInclusive;
use std::path::Path;

use pelage_tracer::MAX_PIXELS;

use super::{CameraEntry, FurEntry, GeometryEntry, LightEntry, SceneFile, SkinEntry, TexelEntry};
use crate::error::FieldError;

/// Magnitudes stay below this: far beyond any scene, and products of three still fit in an `f32`.
const LIMIT: f32 = 1e12;

impl SceneFile {
    /// Checks that every number is in its domain.
    ///
    /// # Errors
    /// The first field that is not.
    pub fn validate(&self) -> Result<(), FieldError> {
        let table = |name: String| Table { file: &self.path, name };
        table("geometry".into()).check("", !self.geometry.is_empty(), "at least one mesh file is needed")?;
        for (i, entry) in self.geometry.iter().enumerate() {
            geometry(&table(format!("geometry[{i}]")), entry)?;
        }
        for (i, entry) in self.skin.iter().enumerate() {
            skin(&table(format!("skin[{i}]")), entry)?;
            let TexelEntry::Fur(entry) = &entry.texel;
            fur(&table(format!("skin[{i}].texel.fur")), entry)?;
        }
        camera(&table("camera".into()), self.camera.as_ref())?;
        for (i, entry) in self.light.iter().enumerate() {
            light(&table(format!("light[{i}]")), entry)?;
        }
        if let Some(entry) = &self.environment {
            let table = table("environment".into());
            table.color("sky", &entry.sky)?;
            table.color("ground", &entry.ground)?;
        }
        let table = table("render".into());
        let [width, height] = self.render.size;
        let pixels = u64::from(width) * u64::from(height);
        let reason = format!("{width} x {height} pixels; from 1 to {MAX_PIXELS} in all are possible");
        table.check("size", (1..=MAX_PIXELS).contains(&pixels), &reason)?;
        let [x0, x1, y0, y1] = self.render.crop.unwrap_or([0, width, 0, height]);
        let reason = format!(
            "must be x0, x1, y0, y1 with x0 < x1 ≤ {width} and y0 < y1 ≤ {height}, the picture's size; \
             it is {x0}, {x1}, {y0}, {y1}"
        );
        table.check("crop", x0 < x1 && x1 <= width && y0 < y1 && y1 <= height, &reason)?;
        table.within("exposure", self.render.exposure, -60.0..=60.0)
    }
}

fn geometry(table: &Table, entry: &GeometryEntry) -> Result<(), FieldError> {
    table.positive("unit", entry.unit)?;
    table.positive("scale", entry.scale)?;
    table.finite("rotate", &entry.rotate)?;
    table.finite("translate", &entry.translate)
}

fn skin(table: &Table, entry: &SkinEntry) -> Result<(), FieldError> {
    table.positive("height", entry.height.unwrap_or(1.0))?;
    for part in entry.lean {
        table.within("lean", part, -50.0..=50.0)?;
    }
    table.positive("tiling", entry.tiling.unwrap_or(1.0))?;
    table.positive("aspect", entry.aspect)?;
    table.check("on", entry.on.iter().all(|name| !name.is_empty()), "must not hold an empty name")?;
    table.color("tint", &entry.tint)
}

fn fur(table: &Table, entry: &FurEntry) -> Result<(), FieldError> {
    let resolution = entry.resolution.is_power_of_two() && (2..=512).contains(&entry.resolution);
    table.check("resolution", resolution, "must be a power of two from 2 to 512")?;
    let count = entry.count.is_none_or(|n| (1..=1_000_000).contains(&n));
    table.check("count", count, "must be from 1 to 1000000")?;
    for (name, value, most) in [
        ("length", entry.length, 1.0),
        ("length_variation", entry.length_variation, 1.0),
        ("root_radius", entry.root_radius, 0.5),
        ("tip_radius", entry.tip_radius, 0.5),
        ("curl", entry.curl, 10.0),
        ("clump", entry.clump, 1.0),
    ] {
        table.within(name, value.unwrap_or(0.0), 0.0..=most)?;
    }
    for slope in entry.lean.unwrap_or_default() {
        table.within("lean", slope, -10.0..=10.0)?;
    }
    for (name, color) in [("root_color", entry.root_color), ("tip_color", entry.tip_color)] {
        for albedo in color.unwrap_or_default() {
            table.within(name, albedo, 0.0..=1.0)?;
        }
    }
    Ok(())
}

fn camera(table: &Table, entry: Option<&CameraEntry>) -> Result<(), FieldError> {
    const FOV: &str = "must be between 0 and 180 degrees";
    let opens = |fov: f32| fov > 0.0 && fov < 180.0;
    match entry {
        Some(CameraEntry::LookAt(c)) => {
            table.finite("look_at.eye", &c.eye)?;
            table.finite("look_at.target", &c.target)?;
            table.direction("look_at.up", &c.up)?;
            table.check("look_at", c.eye != c.target, "the eye must not be at the target")?;
            table.check("look_at.fov", opens(c.fov), FOV)
        }
        Some(CameraEntry::Framed(view)) => {
            table.finite("framed.azimuth", &[view.azimuth])?;
            table.within("framed.elevation", view.elevation, -90.0..=90.0)?;
            table.within("framed.zoom", view.zoom, 1e-3..=1e6)?;
            table.check("framed.fov", opens(view.fov), FOV)
        }
        Some(CameraEntry::Named(_)) | None => Ok(()),
    }
}

fn light(table: &Table, entry: &LightEntry) -> Result<(), FieldError> {
    match entry {
        LightEntry::Directional { direction, illuminance, angle } => {
            table.direction("directional.direction", direction)?;
            table.color("directional.illuminance", illuminance)?;
            table.within("directional.angle", *angle, 0.0..=90.0)
        }
        LightEntry::Point { position, intensity, radius } => {
            table.finite("point.position", position)?;
            table.color("point.intensity", intensity)?;
            table.within("point.radius", *radius, 0.0..=LIMIT)
        }
        LightEntry::Spot { position, direction, intensity, inner, outer, radius } => {
            table.finite("spot.position", position)?;
            table.direction("spot.direction", direction)?;
            table.color("spot.intensity", intensity)?;
            let cone = *inner >= 0.0 && inner < outer && *outer <= 90.0;
            table.check("spot", cone, "0 ≤ inner < outer ≤ 90 degrees must hold")?;
            table.within("spot.radius", *radius, 0.0..=LIMIT)
        }
    }
}

/// A table of the scene, as messages name it.
struct Table<'a> {
    file: &'a Path,
    name: String,
}

impl Table<'_> {
    fn check(&self, field: &str, ok: bool, reason: &str) -> Result<(), FieldError> {
        if ok {
            return Ok(());
        }
        let dot = if field.is_empty() { "" } else { "." };
        let field = format!("{}{dot}{field}", self.name);
        Err(FieldError { file: self.file.to_owned(), field, reason: reason.to_owned() })
    }

    fn positive(&self, field: &str, x: f32) -> Result<(), FieldError> {
        self.check(field, x > 0.0 && x <= LIMIT, "must be positive and at most 1e12")
    }

    fn within(&self, field: &str, x: f32, range: RangeInclusive<f32>) -> Result<(), FieldError> {
        self.check(field, range.contains(&x), &format!("must be from {} to {}", range.start(), range.end()))
    }

    fn finite(&self, field: &str, v: &[f32]) -> Result<(), FieldError> {
        self.check(field, v.iter().all(|x| x.abs() <= LIMIT), "must be finite")
    }

    fn color(&self, field: &str, v: &[f32]) -> Result<(), FieldError> {
        let ok = v.iter().all(|x| (0.0..=LIMIT).contains(x));
        self.check(field, ok, "must hold three numbers from 0 to 1e12")
    }

    fn direction(&self, field: &str, v: &[f32]) -> Result<(), FieldError> {
        let ok = v.iter().all(|x| x.abs() <= LIMIT) && v.iter().any(|&x| x != 0.0);
        self.check(field, ok, "must be finite and not zero")
    }
}
