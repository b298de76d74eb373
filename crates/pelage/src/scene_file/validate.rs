//! Whether the numbers of a described scene make sense: what can be told without reading a mesh file.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use pelage_tracer::MAX_PIXELS;

use super::{CameraEntry, GeometryEntry, LightEntry, SceneFile, SkinEntry};
use crate::choices::Method;
use crate::error::FieldError;

/// Magnitudes stay below this: far beyond any scene, and products of three still fit in an `f32`.
const LIMIT: f32 = 1e12;

impl SceneFile {
    /// Checks that every number is in its domain.
    ///
    /// # Errors
    /// The first field that is not.
    pub fn validate(&self) -> Result<(), FieldError> {
        self.faults().into_iter().next().map_or(Ok(()), Err)
    }

    /// Every field that is out of its domain.
    pub fn faults(&self) -> Vec<FieldError> {
        let faults = RefCell::default();
        let table = |name: String| Table { scene: self, name, faults: &faults };
        table("geometry".into()).check(
            "",
            !self.geometry.is_empty(),
            "at least one mesh file or surface is needed",
        );
        for (i, entry) in self.geometry.iter().enumerate() {
            geometry(&table(format!("geometry[{i}]")), entry);
        }
        for (i, entry) in self.skin.iter().enumerate() {
            skin(&table(format!("skin[{i}]")), entry);
            for (step, groom) in entry.groom.iter().enumerate() {
                if let Err((field, reason)) = groom.validate() {
                    table(format!("skin[{i}].groom[{step}]")).check(&field, false, &reason);
                }
            }
            for (k, share) in entry.texel.iter().enumerate() {
                if let Some((field, reason)) = share.fault() {
                    table(entry.texel_field(i, k)).check(&field, false, &reason);
                }
            }
        }
        camera(&table("camera".into()), self.camera.as_ref());
        for (i, entry) in self.light.iter().enumerate() {
            light(&table(format!("light[{i}]")), entry);
        }
        if let Some(entry) = &self.environment {
            let table = table("environment".into());
            table.color("sky", &entry.sky);
            table.color("ground", &entry.ground);
        }
        let table = table("render".into());
        let [width, height] = self.render.size;
        let pixels = u64::from(width) * u64::from(height);
        let reason = format!("{width} x {height} pixels; from 1 to {MAX_PIXELS} in all are possible");
        table.check("size", (1..=MAX_PIXELS).contains(&pixels), &reason);
        let reason = "is of the reference method only, and the method is cone";
        table.check("spp", self.render.spp.is_none() || self.render.method == Method::Reference, reason);
        let reason = "from 1 to 65536 samples a pixel are possible";
        table.check("spp", self.render.spp.is_none_or(|n| (1..=1 << 16).contains(&n)), reason);
        let [x0, x1, y0, y1] = self.render.crop.unwrap_or([0, width, 0, height]);
        let reason = format!(
            "must be x0, x1, y0, y1 with x0 < x1 ≤ {width} and y0 < y1 ≤ {height}, the picture's size; \
             it is {x0}, {x1}, {y0}, {y1}"
        );
        table.check("crop", x0 < x1 && x1 <= width && y0 < y1 && y1 <= height, &reason);
        table.within("exposure", self.render.exposure, -60.0..=60.0);
        faults.into_inner()
    }
}

fn geometry(table: &Table, entry: &GeometryEntry) {
    let from_surface = entry.surface.is_some();
    table.check("", entry.file.is_some() != from_surface, "needs either a `file` or a `surface`");
    const ONLY: &str = "is of surfaces only";
    table.check("patches", entry.patches.is_none() || from_surface, ONLY);
    table.check("errors", entry.errors.is_none() || from_surface, ONLY);
    table.check("name", entry.name.is_none() || from_surface, ONLY);
    table.check("color", entry.color.is_none() || from_surface, ONLY);
    let one_rule = entry.patches.is_none() || entry.errors.is_none();
    table.check("errors", one_rule, "must be left out beside `patches`");
    let [nu, nv] = entry.patches.unwrap_or([1; 2]).map(u64::from);
    let count = "must be at least 1 each, and 16 million together at most";
    table.check("patches", nu > 0 && nv > 0 && nu * nv <= 16_000_000, count);
    if let Some(Err((field, reason))) = entry.errors.map(|bounds| bounds.validate()) {
        table.check(&format!("errors.{field}"), false, reason);
    }
    table.color("color", &entry.color.unwrap_or_default());
    table.check("subdivide", entry.subdivide <= 10, "must be at most 10");
    table.within("crease_angle", entry.crease_angle, 0.0..=180.0);
    table.positive("unit", entry.unit);
    table.positive("scale", entry.scale);
    table.finite("rotate", &entry.rotate);
    table.finite("translate", &entry.translate);
}

fn skin(table: &Table, entry: &SkinEntry) {
    if let Some(cage) = &entry.cage {
        const OWN: &str = "must be left out beside `cage`, which says where the boxes end";
        table.check("height", entry.height.is_none(), OWN);
        table.check("lean", entry.lean == [0.0; 3], OWN);
        table.check("cage.mesh", cage.mesh.as_deref() != Some(""), "must not be an empty name");
    }
    table.positive("height", entry.height.unwrap_or(1.0));
    for part in entry.lean {
        table.within("lean", part, -50.0..=50.0);
    }
    table.positive("tiling", entry.tiling.unwrap_or(1.0));
    table.positive("aspect", entry.aspect.unwrap_or(1.0));
    let one_width = entry.tiling.is_none() || entry.aspect.is_none();
    table.check("aspect", one_width, "must be left out beside `tiling`, which says how wide a copy is");
    table.check("texel", !entry.texel.is_empty(), "needs one texel at least");
    let weighs = entry.texel.is_empty() || entry.texel.iter().any(|share| share.weight > 0.0);
    table.check("texel", weighs, "needs one texel at least whose weight is not 0");
    table.within("variety.height", entry.variety.height, 0.0..=0.9);
    table.within("variety.color", entry.variety.color, 0.0..=1.0);
    table.check("on", entry.on.iter().all(|name| !name.is_empty()), "must not hold an empty name");
    table.color("tint", &entry.tint);
}

fn camera(table: &Table, entry: Option<&CameraEntry>) {
    const FOV: &str = "must be between 0 and 180 degrees";
    let opens = |fov: f32| fov > 0.0 && fov < 180.0;
    match entry {
        Some(CameraEntry::LookAt(c)) => {
            table.finite("look_at.eye", &c.eye);
            table.finite("look_at.target", &c.target);
            table.direction("look_at.up", &c.up);
            table.check("look_at", c.eye != c.target, "the eye must not be at the target");
            table.check("look_at.fov", opens(c.fov), FOV);
        }
        Some(CameraEntry::Framed(view)) => {
            table.finite("framed.azimuth", &[view.azimuth]);
            table.within("framed.elevation", view.elevation, -90.0..=90.0);
            table.within("framed.zoom", view.zoom, 1e-3..=1e6);
            table.check("framed.fov", opens(view.fov), FOV);
        }
        Some(CameraEntry::Named(_)) | None => {}
    }
}

fn light(table: &Table, entry: &LightEntry) {
    match entry {
        LightEntry::Directional { direction, illuminance, angle } => {
            table.direction("directional.direction", direction);
            table.color("directional.illuminance", illuminance);
            table.within("directional.angle", *angle, 0.0..=90.0);
        }
        LightEntry::Point { position, intensity, radius } => {
            table.finite("point.position", position);
            table.color("point.intensity", intensity);
            table.within("point.radius", *radius, 0.0..=LIMIT);
        }
        LightEntry::Spot { position, direction, intensity, inner, outer, radius } => {
            table.finite("spot.position", position);
            table.direction("spot.direction", direction);
            table.color("spot.intensity", intensity);
            let cone = *inner >= 0.0 && inner < outer && *outer <= 90.0;
            table.check("spot", cone, "0 ≤ inner < outer ≤ 90 degrees must hold");
            table.within("spot.radius", *radius, 0.0..=LIMIT);
        }
    }
}

/// A table of the scene, as messages name it.
struct Table<'a> {
    scene: &'a SceneFile,
    name: String,
    faults: &'a RefCell<Vec<FieldError>>,
}

impl Table<'_> {
    fn check(&self, field: &str, ok: bool, reason: &str) {
        if ok {
            return;
        }
        let dot = if field.is_empty() { "" } else { "." };
        let fault = self.scene.fault(format!("{}{dot}{field}", self.name), reason);
        self.faults.borrow_mut().push(fault);
    }

    fn positive(&self, field: &str, x: f32) {
        self.check(field, x > 0.0 && x <= LIMIT, "must be positive and at most 1e12");
    }

    fn within(&self, field: &str, x: f32, range: RangeInclusive<f32>) {
        self.check(field, range.contains(&x), &format!("must be from {} to {}", range.start(), range.end()));
    }

    fn finite(&self, field: &str, v: &[f32]) {
        self.check(field, v.iter().all(|x| x.abs() <= LIMIT), "must be finite");
    }

    fn color(&self, field: &str, v: &[f32]) {
        let ok = v.iter().all(|x| (0.0..=LIMIT).contains(x));
        self.check(field, ok, "must hold three numbers from 0 to 1e12");
    }

    fn direction(&self, field: &str, v: &[f32]) {
        let ok = v.iter().all(|x| x.abs() <= LIMIT) && v.iter().any(|&x| x != 0.0);
        self.check(field, ok, "must be finite and not zero");
    }
}
