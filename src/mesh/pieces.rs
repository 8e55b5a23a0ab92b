//! Disjoint sets of triangles.

/// A forest in which each tree is a set; its root is its lowest triangle.
pub(super) struct Pieces(Vec<u32>);

impl Pieces {
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    pub fn root(&mut self, mut t: u32) -> u32 {
        while self.0[t as usize] != t {
            self.0[t as usize] = self.0[self.0[t as usize] as usize];
            t = self.0[t as usize];
        }
        t
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    pub fn count(&self) -> usize {
        (0..self.0.len())
            .filter(|&t| self.0[t] as usize == t)
            .count()
    }
}
