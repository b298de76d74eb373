//! The charts of a surface: the islands that its texture coordinates fall into.
//!
//! An atlas gives its charts what room it has, so a copy of the texel would change its size from chart to chart,
//! visibly at every seam. Where nobody asks for a tiling, each chart gets its own; between charts the texel was not
//! continuous before. Where a chart is stretched to more than twice its mean, its copies are halved in size there (and
//! again, octave by octave): at that border strands are cut, but strands of three times the size would show more.

use std::collections::HashMap;
use std::hash::Hash;

use crate::disjoint::DisjointSets;
use crate::polygon::{Polygon, Surface};

/// Which chart each polygon belongs to, and the mean density of texture coordinates there.
pub(crate) struct Charts {
    of_polygon: Vec<u32>,
    /// Units of texture coordinates per metre, by chart; 0 where a chart has no area.
    density: Vec<f64>,
    /// By how much the copies on a polygon are finer than on the rest of its chart: a power of two.
    finer: Vec<f64>,
}

impl Charts {
    /// Polygons that share a vertex with the same texture coordinates there are in one chart.
    pub fn new(surface: &Surface) -> Self {
        let polygons = &surface.polygons;
        // A set is named by its smallest number, so that charts are numbered by their first polygon.
        let mut sets = DisjointSets::new(polygons.len());
        let mut first_at = AtVertex::new(surface.positions.len());
        for (i, polygon) in polygons.iter().enumerate() {
            for (corner, &vertex) in polygon.corners().iter().enumerate() {
                let uv = polygon.laid[corner].to_array().map(|x| (x + 0.0).to_bits());
                let first = *first_at.entry(vertex, uv, i as u32);
                sets.join(first, i as u32);
            }
        }
        let of_polygon: Vec<u32> = (0..polygons.len() as u32).map(|i| sets.root(i)).collect();
        let mut areas = vec![(0.0, 0.0); polygons.len()];
        for (polygon, &chart) in polygons.iter().zip(&of_polygon) {
            let (uv_area, area) = &mut areas[chart as usize];
            let here = uv_area_of(polygon);
            if here > 0.0 {
                *uv_area += here;
                *area += polygon.area_vector(&surface.positions).length();
            }
        }
        let density: Vec<f64> = areas.into_iter().map(|(uv, area)| ratio(uv, area)).collect();

        // The density around a vertex: single polygons scatter, and would border on each other in patches.
        let mut around = AtVertex::new(surface.positions.len());
        for (polygon, &chart) in polygons.iter().zip(&of_polygon) {
            let here = (uv_area_of(polygon), polygon.area_vector(&surface.positions).length());
            for &vertex in polygon.corners() {
                let (uv_area, area) = around.entry(vertex, chart, (0.0, 0.0));
                *uv_area += here.0;
                *area += here.1;
            }
        }
        let finer = (polygons.iter().zip(&of_polygon))
            .map(|(polygon, &chart)| {
                let corners = polygon.corners().iter().filter_map(|&v| around.get(v, chart));
                let (uv_area, area) = corners.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
                let octaves = (density[chart as usize] / ratio(uv_area, area)).log2();
                if octaves.is_finite() { octaves.trunc().clamp(-4.0, 4.0).exp2() } else { 1.0 }
            })
            .collect();
        Self { of_polygon, density, finer }
    }

    /// The number of the chart that polygon `index` belongs to: that of its first polygon.
    pub fn number(&self, index: usize) -> u32 {
        self.of_polygon[index]
    }

    /// The density of the chart that polygon `index` belongs to.
    pub fn density(&self, index: usize) -> f64 {
        self.density[self.of_polygon[index] as usize]
    }

    /// By how much the copies on polygon `index` are finer than its chart's density asks for.
    pub fn finer(&self, index: usize) -> f64 {
        self.finer[index]
    }
}

/// Values by vertex and a key of which most vertices have one, those at seams a few.
struct AtVertex<K, V> {
    first: Vec<Option<(K, V)>>,
    further: HashMap<(u32, K), V>,
}

impl<K: Copy + Eq + Hash, V: Copy> AtVertex<K, V> {
    fn new(vertices: usize) -> Self {
        Self { first: (0..vertices).map(|_| None).collect(), further: HashMap::new() }
    }

    /// The value there, which is `default` where there was none.
    fn entry(&mut self, vertex: u32, key: K, default: V) -> &mut V {
        let first = self.first[vertex as usize].get_or_insert((key, default));
        if first.0 == key { &mut first.1 } else { self.further.entry((vertex, key)).or_insert(default) }
    }

    fn get(&self, vertex: u32, key: K) -> Option<&V> {
        match &self.first[vertex as usize] {
            Some((k, value)) if *k == key => Some(value),
            _ => self.further.get(&(vertex, key)),
        }
    }
}

/// Mean units of texture coordinates per metre over a whole surface; 0 where no face has any area in them.
pub(crate) fn mean_density(surface: &Surface) -> f64 {
    let (mut uv_area, mut area) = (0.0, 0.0);
    for polygon in &surface.polygons {
        let here = uv_area_of(polygon);
        if here > 0.0 {
            uv_area += here;
            area += polygon.area_vector(&surface.positions).length();
        }
    }
    ratio(uv_area, area)
}

fn ratio(uv_area: f64, area: f64) -> f64 {
    if area > 0.0 { (uv_area / area).sqrt() } else { 0.0 }
}

/// Area in texture coordinates; each half on its own, because those of a quad may be mirrored against each other.
fn uv_area_of(polygon: &Polygon) -> f64 {
    let n = polygon.corners().len();
    let uv = |i: usize| polygon.laid[i].as_dvec2() - polygon.laid[0].as_dvec2();
    (1..n - 1).map(|i| 0.5 * uv(i).perp_dot(uv(i + 1)).abs()).sum()
}
