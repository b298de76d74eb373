//! Points spread evenly over a square, however many there are.

use glam::{DVec2, dvec2};

/// The `i`-th point of the R₂ sequence in the unit square: steps by 1/ρ and 1/ρ², where ρ³ = ρ + 1, from its middle on.
/// Any points of it that follow each other are about as far from each other as so many can be. \[Roberts18\]
pub fn evenly(i: usize) -> DVec2 {
    (0.5 + i as f64 * dvec2(0.754_877_666_246_692_7, 0.569_840_290_998_053_3)).fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_steps_are_the_plastic_numbers_and_no_point_is_near_another() {
        let step = evenly(1) - evenly(0);
        let step = step - step.floor();
        // ρ³ = ρ + 1 with 1/ρ = x reads 1 = x² + x³, and y is x².
        assert!((step.x.powi(2) + step.x.powi(3) - 1.0).abs() < 1e-12);
        assert!((step.y - step.x.powi(2)).abs() < 1e-12);
        // Of n points in a square, on a lattice of triangles neighbours are 1.07/√n apart; here at least half of that, over the border too.
        for count in [10, 100, 500] {
            let points: Vec<DVec2> = (7..7 + count).map(evenly).collect();
            for (i, a) in points.iter().enumerate() {
                for b in &points[..i] {
                    let apart = a - b;
                    let apart = (apart - apart.round()).length() * (count as f64).sqrt();
                    assert!(apart > 0.53, "{count}: {apart}");
                }
            }
        }
    }
}
