//! Disjoint sets (union-find) whose representative is the least member.

/// Sets of the numbers below a count.
#[derive(Clone, Debug)]
pub(crate) struct DisjointSets(Vec<usize>);

impl DisjointSets {
    /// Each member alone.
    pub(crate) fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// The least member of a set.
    pub(crate) fn first_of(&mut self, mut member: usize) -> usize {
        while self.0[member] != member {
            self.0[member] = self.0[self.0[member]];
            member = self.0[member];
        }
        member
    }

    /// Makes one set of two.
    pub(crate) fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (self.first_of(one), self.first_of(other));
        self.0[one.max(other)] = one.min(other);
    }
}
