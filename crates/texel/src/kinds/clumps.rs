//! What strands gather around: locks of fur, tufts of grass, cushions of moss.

use glam::Vec2;

use super::scatter::scattered;
use crate::random::Random;

/// A clump: which one it is, and its middle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clump {
    pub(super) number: u32,
    pub(super) middle: Vec2,
}

/// Clumps, sorted into a grid over the periodic tile to find the nearest.
pub(super) struct Clumps {
    side: usize,
    cells: Vec<Vec<Clump>>,
}

impl Clumps {
    /// So many, scattered evenly; at least one.
    pub(super) fn new(count: u32, seed: u64) -> Self {
        let count = count.max(1);
        let side = ((count as f32 / 2.0).sqrt() as usize).max(1);
        let mut cells = vec![Vec::new(); side * side];
        for i in 0..count {
            // Few as they are, their lattice would show.
            let p = scattered(i, count, 0.7, &mut Random::new(seed, i.into()));
            let [x, y] = [p.x, p.y].map(|c| ((c * side as f32) as usize).min(side - 1));
            cells[x + side * y].push(Clump { number: i, middle: p });
        }
        Self { side, cells }
    }

    /// The clump whose middle is nearest to `p` in [0, 1)², in whichever copy of the tile it lies.
    pub(super) fn nearest(&self, p: Vec2) -> Clump {
        let side = self.side as i32;
        let at = (p * side as f32).floor().as_ivec2();
        let mut best = (f32::INFINITY, Clump { number: 0, middle: p });
        for dy in -1..=1 {
            for dx in -1..=1 {
                let [x, y] = [at.x + dx, at.y + dy];
                let tile = Vec2::new(x.div_euclid(side) as f32, y.div_euclid(side) as f32);
                let cell = x.rem_euclid(side) + side * y.rem_euclid(side);
                for &Clump { number, middle } in &self.cells[cell as usize] {
                    let distance = p.distance_squared(middle + tile);
                    if distance < best.0 {
                        best = (distance, Clump { number, middle: middle + tile });
                    }
                }
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all middles in the tile and its eight neighbours: nothing is different at the tile's edge.
    #[test]
    fn the_nearest_is_found_across_the_edge() {
        for count in [1, 2, 7, 90] {
            let clumps = Clumps::new(count, 5);
            let middles: Vec<Vec2> = clumps.cells.iter().flatten().map(|clump| clump.middle).collect();
            assert_eq!(middles.len(), count as usize);
            for k in 0..1000 {
                let p = scattered(k, 1000, 0.4, &mut Random::new(9, k.into()));
                let tiles = (0..9).map(|t| Vec2::new((t % 3) as f32, (t / 3) as f32) - 1.0);
                let all = tiles.flat_map(|tile| middles.iter().map(move |&middle| middle + tile));
                let nearest = all.map(|middle| middle.distance(p)).fold(f32::INFINITY, f32::min);
                assert!((clumps.nearest(p).middle.distance(p) - nearest).abs() < 1e-6, "{count}: {p}");
            }
        }
    }
}
