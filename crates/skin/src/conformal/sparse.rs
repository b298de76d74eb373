//! Symmetric positive definite systems, by sparse Cholesky factors with few entries. [Davis06]
//!
//! Plain scalar arithmetic in one order: the same bits on every run and every machine.

use rsparse::data::Sprs;
use rsparse::{chol, lsolve, ltsolve, schol};

/// An entry of a matrix: row, column, value.
pub(super) type Entry = (usize, usize, f64);

/// A factorized matrix.
pub(super) struct Factor {
    /// Where the factorization put each unknown.
    place: Vec<usize>,
    lower: Sprs<f64>,
}

/// How rsparse orders unknowns: as they are, and by approximate minimum degree, which needs three.
const NATURAL: i8 = -1;
const MINIMUM_DEGREE: i8 = 0;

impl Factor {
    /// Factorizes the `n` × `n` matrix with these entries, both triangles given; entries of one place add up, in
    /// their order. `None` where it is not positive definite.
    pub fn new(n: usize, mut entries: Vec<Entry>) -> Option<Self> {
        if n == 0 {
            return None;
        }
        // Stable: sums come out the same always.
        entries.sort_by_key(|&(row, column, _)| (column, row));
        let mut matrix = Sprs { nzmax: 0, m: n, n, p: vec![0; n + 1], i: Vec::new(), x: Vec::new() };
        for same in entries.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let value: f64 = same.iter().map(|entry| entry.2).sum();
            // What cancels would only make more entries of the factor.
            if value != 0.0 {
                let (row, column, _) = same[0];
                matrix.i.push(row);
                matrix.x.push(value);
                matrix.p[column + 1] += 1;
            }
        }
        for column in 0..n {
            matrix.p[column + 1] += matrix.p[column];
        }
        matrix.nzmax = matrix.x.len();
        let mut symbolic = schol(&matrix, if n > 2 { MINIMUM_DEGREE } else { NATURAL });
        let lower = chol(&matrix, &mut symbolic).ok()?.l;
        let place = match symbolic.pinv {
            Some(pinv) => pinv.into_iter().map(usize::try_from).collect::<Result<_, _>>().ok()?,
            None => (0..n).collect(),
        };
        Some(Self { place, lower })
    }

    /// The unknowns for a right-hand side of as many numbers.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; right.len()];
        for (&place, &value) in self.place.iter().zip(right) {
            x[place] = value;
        }
        lsolve(&self.lower, &mut x);
        ltsolve(&self.lower, &mut x);
        self.place.iter().map(|&place| x[place]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_of_springs() {
        // −x[i−1] + 2 x[i] − x[i+1] = 0 between walls at 0 and 1: x[i] = (i + 1) / (n + 1).
        let n = 9;
        let mut entries = Vec::new();
        for i in 0..n {
            // In two halves, which add up.
            entries.extend([(i, i, 1.5), (i, i, 0.5)]);
            if i > 0 {
                entries.extend([(i, i - 1, -1.0), (i - 1, i, -1.0)]);
            }
        }
        let mut right = vec![0.0; n];
        right[n - 1] = 1.0;
        let x = Factor::new(n, entries).expect("positive definite").solve(&right);
        for (i, x) in x.iter().enumerate() {
            assert!((x - (i + 1) as f64 / (n + 1) as f64).abs() < 1e-14, "{i}: {x}");
        }
        assert!(Factor::new(1, vec![(0, 0, -1.0)]).is_none() && Factor::new(0, Vec::new()).is_none());
    }
}
