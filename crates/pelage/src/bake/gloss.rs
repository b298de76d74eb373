//! The one specular albedo and roughness of a texel whose model has many.

use pelage_geom::{Material, MaterialId};

/// What stands for all materials, and what is lost by it.
pub(super) struct Gloss {
    /// The mean over the area.
    pub(super) specular: f32,
    /// The mean over the area, each part weighted by how much it reflects.
    pub(super) roughness: f32,
    pub(super) warnings: Vec<String>,
}

impl Gloss {
    /// `areas` holds the area that wears each material.
    pub(super) fn new(materials: &[Material], areas: &[(MaterialId, f64)]) -> Self {
        let worn: Vec<(&Material, f64)> = areas
            .iter()
            .filter(|(_, area)| *area > 0.0)
            .filter_map(|&(id, area)| Some((materials.get(id.0 as usize)?, area)))
            .collect();
        let mean = |value: &dyn Fn(&Material) -> f32, weight: &dyn Fn(&Material) -> f64| {
            let weights = || worn.iter().map(|(material, area)| area * weight(material));
            let sum: f64 =
                worn.iter().zip(weights()).map(|((material, _), w)| w * f64::from(value(material))).sum();
            (sum / weights().sum::<f64>()) as f32
        };
        let specular = mean(&|m| m.specular, &|_| 1.0);
        // What reflects nothing has no say in how it does, unless nothing reflects.
        let share: &dyn Fn(&Material) -> f64 =
            if specular > 0.0 { &|m| f64::from(m.specular) } else { &|_| 1.0 };
        let roughness = mean(&|m| m.roughness, share);
        let mut warnings = Vec::new();
        let mut differ = |what: &str, value: &dyn Fn(&Material) -> Option<f32>, most: f32, mean: f32| {
            let values = || worn.iter().filter_map(|(material, _)| value(material));
            let [low, high] = [values().fold(f32::MAX, f32::min), values().fold(f32::MIN, f32::max)];
            if high - low > most {
                warnings.push(format!(
                    "its materials differ in {what}, from {low:.2} to {high:.2}: the texel has one, {mean:.2}"
                ));
            }
        };
        differ("specular albedo", &|m| Some(m.specular), 0.05, specular);
        differ("roughness", &|m| (m.specular > 0.0).then_some(m.roughness), 0.2, roughness);
        let lamps: Vec<String> = worn
            .iter()
            .filter(|(material, _)| material.emissive.max_element() > 0.0)
            .map(|(material, _)| format!("`{}`", material.name))
            .collect();
        if !lamps.is_empty() {
            let names = lamps.join(", ");
            warnings.push(format!("the light that {names} gives off is left out: texels give off none"));
        }
        Self { specular, roughness, warnings }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_by_area_and_a_warning_each() {
        let material = |specular, roughness| Material { specular, roughness, ..Material::default() };
        let materials = [material(0.0, 0.9), material(0.1, 0.2), material(0.3, 0.6), material(1.0, 1.0)];
        let areas = [(MaterialId(0), 2.0), (MaterialId(1), 1.0), (MaterialId(2), 1.0), (MaterialId(3), 0.0)];
        let gloss = Gloss::new(&materials, &areas);
        // (0.1 + 0.3)/4; (0.1·0.2 + 0.3·0.6)/0.4.
        assert!((gloss.specular - 0.1).abs() < 1e-6 && (gloss.roughness - 0.5).abs() < 1e-6);
        assert_eq!(gloss.warnings.len(), 2, "{:?}", gloss.warnings);
        let matt = Gloss::new(&materials[..1], &areas[..1]);
        assert_eq!((matt.specular, matt.roughness), (0.0, 0.9));
        assert!(matt.warnings.is_empty());
    }

    #[test]
    fn lamps_are_named_once() {
        let lamp = Material { name: "bulb".into(), emissive: glam::Vec3::ONE, ..Material::default() };
        let gloss = Gloss::new(&[lamp], &[(MaterialId(0), 1.0)]);
        assert_eq!(gloss.warnings, ["the light that `bulb` gives off is left out: texels give off none"]);
    }
}
