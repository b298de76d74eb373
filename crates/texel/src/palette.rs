//! The directions or colours that a level uses, few enough to be named by 11 or 12 bits.
//!
//! What is used again and again (a flat sheet, a blade, the facets of a model) is kept exactly; what is not is gathered
//! on the finest grid of which few enough cells are used, each cell's mean standing for what lies in it.

use std::cmp::Reverse;

/// Points of which a voxel names one; D coordinates of an integer grid.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Palette<const D: usize> {
    points: Vec<[i16; D]>,
}

impl<const D: usize> Palette<D> {
    /// At most `most` points for those given, and the index of the one that stands for each.
    pub(crate) fn gather(given: &[[i16; D]], most: usize) -> (Self, Vec<u16>) {
        let mut used: Vec<([i16; D], u32)> = Vec::new();
        let mut sorted = given.to_vec();
        sorted.sort_unstable();
        for same in sorted.chunk_by(|a, b| a == b) {
            used.push((same[0], same.len() as u32));
        }
        // Where half as many as there may be make two thirds of what is given, they stay as they are.
        let mut exact = Vec::new();
        if used.len() > most {
            used.sort_by_key(|&(point, times)| (Reverse(times), point));
            let often: u64 = used[..most / 2].iter().map(|&(_, times)| u64::from(times)).sum();
            if 3 * often >= 2 * given.len() as u64 {
                exact = used.drain(..most / 2).map(|(point, _)| point).collect();
                exact.sort_unstable();
            }
        }
        let most = most - exact.len();
        // The width of the finest grid that has few enough cells: between one that has, and one that has not.
        let (mut wide, mut narrow) = (1_i32, 0);
        while count(&used, wide) > most {
            (wide, narrow) = (2 * wide, wide);
        }
        while wide - narrow > 1 {
            let middle = (wide + narrow) / 2;
            if count(&used, middle) > most { narrow = middle } else { wide = middle }
        }
        let mut cells: Vec<([i32; D], [i16; D], u32)> =
            used.iter().map(|&(point, times)| (cell(point, wide), point, times)).collect();
        cells.sort_unstable();
        let (mut names, mut points) = (Vec::new(), exact.clone());
        for one in cells.chunk_by(|a, b| a.0 == b.0) {
            let whole: i64 = one.iter().map(|&(_, _, times)| i64::from(times)).sum();
            let mean = |axis: usize| {
                let sum: i64 =
                    one.iter().map(|&(_, point, times)| i64::from(point[axis]) * i64::from(times)).sum();
                (sum as f64 / whole as f64).round() as i16
            };
            names.push(one[0].0);
            points.push(std::array::from_fn(mean));
        }
        let index = |point: &[i16; D]| match exact.binary_search(point) {
            Ok(index) => index as u16,
            Err(_) => (exact.len() + names.binary_search(&cell(*point, wide)).unwrap_or_default()) as u16,
        };
        let indices = given.iter().map(index).collect();
        (Self { points }, indices)
    }

    pub(crate) fn from_points(points: Vec<[i16; D]>) -> Self {
        Self { points }
    }

    pub(crate) fn points(&self) -> &[[i16; D]] {
        &self.points
    }

    /// The point of an index; zero, if there is none.
    #[inline]
    pub(crate) fn get(&self, index: usize) -> [i16; D] {
        self.points.get(index).copied().unwrap_or([0; D])
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(self.points.as_slice())
    }
}

fn cell<const D: usize>(point: [i16; D], width: i32) -> [i32; D] {
    // From the lowest corner of all, so that one cell may hold everything.
    point.map(|c| (i32::from(c) - i32::from(i16::MIN)) / width)
}

/// How many cells of a grid are used.
fn count<const D: usize>(used: &[([i16; D], u32)], width: i32) -> usize {
    let mut cells: Vec<[i32; D]> = used.iter().map(|&(point, _)| cell(point, width)).collect();
    cells.sort_unstable();
    cells.dedup();
    cells.len()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn few_are_kept_and_many_are_gathered_nearby(
            points in prop::collection::vec(prop::array::uniform2(-3000_i16..3000), 0..400),
            most in 1_usize..50,
        ) {
            let (palette, indices) = Palette::gather(&points, most);
            prop_assert!(palette.points().len() <= most);
            prop_assert_eq!(indices.len(), points.len());
            let (all, indices_of_all) = Palette::gather(&points, 400);
            for (i, point) in points.iter().enumerate() {
                prop_assert_eq!(all.get(indices_of_all[i].into()), *point);
                // One point for all of 6000² is at most so far.
                let [x, y] = palette.get(indices[i].into());
                prop_assert!((x - point[0]).abs() <= 6000 && (y - point[1]).abs() <= 6000);
            }
        }
    }

    #[test]
    fn what_is_used_often_stays_as_it_is() {
        // 50 points four times, and 99 others once: of 100 names the 50 have half.
        let often: Vec<[i16; 2]> = (0..50).map(|i| [i, 3 * i]).collect();
        let points: Vec<_> = [&often[..]; 4].concat().into_iter().chain((0..99).map(|i| [-i, 1])).collect();
        let (palette, indices) = Palette::gather(&points, 100);
        assert!(palette.points().len() <= 100);
        for (point, &index) in points.iter().zip(&indices).take(200) {
            assert_eq!(palette.get(index.into()), *point);
        }
    }

    #[test]
    fn a_grid_is_as_fine_as_it_may_be() {
        // 100 × 100 points, 10 apart: 2500 places hold them by twos and twos, so that none is further off than 10.
        let points: Vec<[i16; 2]> = (0..10_000).map(|i| [10 * (i % 100), 10 * (i / 100)]).collect();
        let (palette, indices) = Palette::gather(&points, 2500);
        for (point, &index) in points.iter().zip(&indices) {
            let [x, y] = palette.get(index.into());
            assert!((x - point[0]).abs() <= 10 && (y - point[1]).abs() <= 10, "{point:?} {x} {y}");
        }
    }
}
