//! Fewer points that stand for all: of a voxel whose surface was looked around from at more points than it can keep.

use glam::Vec3;

use crate::random::Random;

/// A point as a level sees it.
#[derive(Clone, Copy)]
pub(crate) struct Found {
    pub(crate) normal: Vec3,
    pub(crate) color: Vec3,
    pub(crate) open: u64,
    /// The surface that it stands for, in any unit.
    pub(crate) weight: f32,
}

/// Of those that face alike (20°) and are open to alike, the heaviest stands for all.
pub(crate) fn merge_alike(found: &mut Vec<Found>) {
    const COSINE: f32 = 0.94;
    /// Cells of the mask in which they may differ: three squares of four.
    const FEW: u32 = 12;
    found.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    let mut kept: Vec<Found> = Vec::with_capacity(found.len());
    for one in found.drain(..) {
        let like =
            |f: &&mut Found| f.normal.dot(one.normal) > COSINE && (f.open ^ one.open).count_ones() <= FEW;
        match kept.iter_mut().find(like) {
            Some(f) => {
                f.weight += one.weight;
                f.color = f.color.lerp(one.color, one.weight / f.weight);
            }
            None => kept.push(one),
        }
    }
    *found = kept;
}

/// Keeps at most `most`, those seen from more directions rather, each weighted for those it stands for.
pub(crate) fn thin_out(found: &mut Vec<Found>, most: usize, random: &mut Random) {
    // Those that are hardly seen are not so rare that one of them would count for very many.
    let importance = |f: &Found| f.weight * (f.open.count_ones() + 8) as f32;
    if found.len() <= most {
        return;
    }
    // Even steps through those in order leave every kind of them its share.
    found.sort_by_cached_key(|f| {
        let [x, y] = crate::packed::octahedral(f.normal).map(|c| ((i32::from(c) + 32768) >> 12) as u32);
        (x, if x.is_multiple_of(2) { y } else { 15 - y }, f.open.count_ones())
    });
    let step = found.iter().map(importance).sum::<f32>() / most as f32;
    let mut next = step * random.unit();
    let mut sum = 0.0;
    let mut kept = 0;
    for i in 0..found.len() {
        let one = found[i];
        let share = importance(&one);
        let mut times = 0;
        sum += share;
        while next < sum && kept + times < most {
            next += step;
            times += 1;
        }
        if times > 0 {
            found[kept] = Found { weight: one.weight * times as f32 * step / share, ..one };
            kept += 1;
        }
    }
    found.truncate(kept);
}
