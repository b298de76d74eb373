//! A chord, copy by copy of the texel: where copies differ, each is gone through on its own.

use glam::{IVec2, Vec2};

use super::path::Chord;

/// The part of a chord in one copy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    /// Which copy of the lattice.
    pub copy: [i32; 2],
    /// From where to where of the chord, as fractions.
    pub range: [f32; 2],
}

/// The copies that a chord goes through, in its order: the parts abut, and together they are the chord.
pub(crate) struct Stretches {
    from: Vec2,
    delta: Vec2,
    copy: IVec2,
    at: f32,
}

impl Stretches {
    /// Coordinates beyond this many copies have no copy to be told of (an `f32` has 24 bits): such chords have no parts.
    const REACH: f32 = (1 << 22) as f32;

    pub fn of(chord: &Chord) -> Self {
        let [from, to] = chord.at.map(|at| at.truncate());
        let usable = [from, to].iter().all(|p| p.abs().max_element() < Self::REACH && !p.is_nan());
        let at = if usable { 0.0 } else { 1.0 };
        Self { from, delta: to - from, copy: from.floor().as_ivec2(), at }
    }
}

impl Iterator for Stretches {
    type Item = Stretch;

    fn next(&mut self) -> Option<Stretch> {
        while self.at < 1.0 {
            // Where the chord would leave the copy in s, and in t.
            let border = |axis: usize| match self.delta[axis] {
                0.0 => f32::INFINITY,
                d => ((self.copy[axis] + i32::from(d > 0.0)) as f32 - self.from[axis]) / d,
            };
            let (s, t) = (border(0), border(1));
            let (axis, leave) = if s <= t { (0, s) } else { (1, t) };
            let (copy, begin) = (self.copy.to_array(), self.at);
            // Never backwards, whatever rounding does.
            self.at = leave.clamp(begin, 1.0);
            self.copy[axis] += if self.delta[axis] > 0.0 { 1 } else { -1 };
            if self.at > begin {
                return Some(Stretch { copy, range: [begin, self.at] });
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use proptest::prelude::*;

    use super::*;

    fn parts(from: [f32; 2], to: [f32; 2]) -> Vec<Stretch> {
        let [a, b] = [from, to].map(|[s, t]| Vec3::new(s, t, 0.5));
        Stretches::of(&Chord { t: [0.0, 1.0], at: [a, b] }).collect()
    }

    #[test]
    fn a_chord_is_told_copy_by_copy() {
        // From (.5, .25) by (−2, 1): s is whole after ¼ and ¾, t after ¾ too.
        let expected = [([0, 0], [0.0, 0.25]), ([-1, 0], [0.25, 0.75]), ([-2, 1], [0.75, 1.0])];
        let expected = expected.map(|(copy, range)| Stretch { copy, range });
        assert_eq!(parts([0.5, 0.25], [-1.5, 1.25]), expected);
        // Along a border it is in the copy above; leaving it downwards, in the one below.
        assert_eq!(parts([1.0, 0.2], [1.0, 0.4]), [Stretch { copy: [1, 0], range: [0.0, 1.0] }]);
        assert_eq!(parts([1.0, 0.2], [0.5, 0.2]), [Stretch { copy: [0, 0], range: [0.0, 1.0] }]);
        assert_eq!(parts([0.5, 0.2], [1.0, 0.2]), [Stretch { copy: [0, 0], range: [0.0, 1.0] }]);
        // A point is in its copy too.
        assert_eq!(parts([2.5, -0.5], [2.5, -0.5]), [Stretch { copy: [2, -1], range: [0.0, 1.0] }]);
        assert_eq!(parts([f32::NAN, 0.0], [1.0, 1.0]), []);
        assert_eq!(parts([0.0, 0.0], [1e30, 1.0]), []);
    }

    proptest! {
        #[test]
        fn parts_abut_and_lie_in_their_copies(
            from in prop::array::uniform2(-9.0_f32..9.0),
            to in prop::array::uniform2(-9.0_f32..9.0),
        ) {
            let parts = parts(from, to);
            prop_assert_eq!(parts[0].range[0], 0.0);
            prop_assert_eq!(parts[parts.len() - 1].range[1], 1.0);
            for pair in parts.windows(2) {
                prop_assert_eq!(pair[0].range[1], pair[1].range[0]);
            }
            for Stretch { copy, range } in parts {
                let middle = 0.5 * (range[0] + range[1]);
                for axis in 0..2 {
                    let at = from[axis] + (to[axis] - from[axis]) * middle - copy[axis] as f32;
                    // Coordinates of up to 18 carry errors of 18 · 2⁻²³.
                    prop_assert!((-1e-5..=1.0 + 1e-5).contains(&at), "{} in {:?}", at, copy);
                }
            }
        }
    }
}
