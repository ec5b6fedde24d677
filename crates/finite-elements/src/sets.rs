//! Disjoint sets.

/// Numbers in sets that are joined pair by pair. Each set is known by its least member.
#[derive(Clone, Debug)]
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// So many numbers, each alone.
    ///
    /// # Panics
    /// If they are more than `u32` can count.
    pub fn new(count: usize) -> Self {
        assert!(u32::try_from(count).is_ok());
        Self((0..count as u32).collect())
    }

    /// So many numbers, of which those of each group are in one set.
    ///
    /// # Panics
    /// As [`Self::new`] and [`Self::join`].
    pub fn of_groups<'a>(count: usize, groups: impl Iterator<Item = &'a [u32]>) -> Self {
        let mut sets = Self::new(count);
        for group in groups {
            group.iter().for_each(|&member| sets.join(group[0], member));
        }
        sets
    }

    /// The least member of the set of a number.
    ///
    /// # Panics
    /// If there is no such number.
    pub fn root(&mut self, mut member: u32) -> u32 {
        while self.0[member as usize] != member {
            let above = self.0[self.0[member as usize] as usize];
            self.0[member as usize] = above;
            member = above;
        }
        member
    }

    /// Makes one set of those of two numbers.
    ///
    /// # Panics
    /// If there is no such number.
    pub fn join(&mut self, a: u32, b: u32) {
        // The lesser stays, so that paths are short where meshes are numbered along their bodies.
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
