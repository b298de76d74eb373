//! Disjoint sets of numbers, for what is connected to what.

/// Sets of the numbers 0 to n − 1, each named by its smallest.
pub(crate) struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Every number by itself.
    pub fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect() }
    }

    /// The smallest number in the set of `i`; halves the way for the next call.
    pub fn root(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let above = self.parent[i as usize];
            self.parent[i as usize] = self.parent[above as usize];
            i = self.parent[i as usize];
        }
        i
    }

    /// Makes one set of those of two numbers.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
