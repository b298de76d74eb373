//! What a point of the surface sees of its surroundings: rays towards the cells of the nodes.
//!
//! What is seen from v and lit from l is a product of two visibilities, which have much in common where v and l are
//! near each other. Of each cell therefore two directions are drawn, independently: the product of one's visibility with
//! the other's is right on the mean, in the same cell too.

use glam::Vec3;

use super::nodes::draw;
use crate::random::Random;
use crate::surfel::{Surfel, direction};

/// The reflectances of levels below this one are tabulated.
pub(crate) const TABLED: usize = 3;

/// A point of the surface, and what nothing near blocks it from.
#[derive(Clone, Debug)]
pub(crate) struct Outlook {
    pub(super) normal: Vec3,
    /// Linear albedo.
    pub(super) color: Vec3,
    /// The surface that it stands for, in any unit.
    pub(super) weight: f32,
    /// Twice a direction of each cell, of those in front of it that are open at any level.
    pub(super) open: [Vec<Open>; 2],
}

/// A direction in which nothing near blocks a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    pub(super) cell: u8,
    /// Unit vector.
    pub(super) direction: Vec3,
    /// The coarsest level at whose [`Surfel::reach`] nothing does.
    pub(super) level: u8,
}

impl Outlook {
    /// Of a point with a unit `normal` and linear `color` that stands for so much surface. `distance` tells how far it is to
    /// what blocks the way in a unit direction: anything beyond the second number if nothing does up to there, anything
    /// below the first if something does before. `None` if nothing is open, and as a rule if hardly anything is: few such points
    /// count for many.
    pub(crate) fn new(
        normal: Vec3,
        color: Vec3,
        weight: f32,
        random: &mut Random,
        distance: impl Fn(Vec3, [f32; 2]) -> f32,
    ) -> Option<Self> {
        /// Rays that tell whether a point is worth more.
        const FIRST: usize = 8;
        /// Of those, how many are open where all points are kept.
        const ENOUGH: f32 = 4.0;
        let reaches: [f32; TABLED] = std::array::from_fn(|level| Surfel::reach(1.0 / (1 << level) as f32));
        let [farthest, nearest] = [reaches[0], reaches[TABLED - 1]];
        let is_open = |d: Vec3| distance(d, [nearest, nearest]) >= nearest;
        let first = |_: &usize| is_open(direction(normal, [random.signed(), random.signed()]));
        let open = (0..FIRST).filter(first).count();
        let kept = ((open as f32 + 0.5) / ENOUGH).min(1.0);
        if random.unit() >= kept {
            return None;
        }
        let mut look = || -> Vec<Open> {
            let drawn = draw(random).into_iter().enumerate().filter(|(_, d)| normal.dot(*d) > 0.0);
            let open = drawn.filter_map(|(cell, direction)| {
                let free = distance(direction, [nearest, farthest]);
                let level = reaches.iter().position(|reach| free >= *reach)?;
                Some(Open { cell: cell as u8, direction, level: level as u8 })
            });
            open.collect()
        };
        let open = [look(), look()];
        let is_seen = open.iter().any(|set| !set.is_empty());
        is_seen.then(|| Self { normal, color, weight: weight / kept, open })
    }
}
