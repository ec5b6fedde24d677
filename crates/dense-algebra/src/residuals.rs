//! Linear systems with one operator and several right-hand sides, by conjugate residuals.

/// What steps and residuals must be able to do.
pub trait Vector: Clone {
    /// `self += factor * other`.
    fn add(&mut self, factor: f64, other: &Self);
    /// `self *= factor`.
    fn scale(&mut self, factor: f64);
}

/// A vector with an inner product.
pub trait Inner: Vector {
    /// The product.
    fn dot(&self, other: &Self) -> f64;

    /// Its norm.
    fn norm(&self) -> f64 {
        self.dot(self).max(0.0).sqrt()
    }
}

/// Conjugate residuals (GCR) that keep what they searched: what served one right-hand side serves the next ones too.
#[derive(Clone, Debug)]
pub struct ConjugateResiduals<S, R> {
    /// Steps and their images under the operator; the images are orthonormal.
    searched: Vec<(S, R)>,
    most: usize,
}

impl<S: Vector, R: Inner> ConjugateResiduals<S, R> {
    /// Keeps at most `most` directions.
    pub fn new(most: usize) -> Self {
        Self {
            searched: Vec::new(),
            most,
        }
    }

    /// Adds to `found`, which is zero, the step whose image is `rest`. `search` gives the next step for what is left, and its image. `None` if
    /// `tolerance` (relative) is not reached.
    pub fn solve(&mut self, mut rest: R, mut found: S, tolerance: f64, search: impl Fn(&R) -> (S, R)) -> Option<S> {
        let take = |(step, image): &(S, R), rest: &mut R, found: &mut S| {
            let c = rest.dot(image);
            rest.add(-c, image);
            found.add(c, step);
        };
        let norm = rest.norm();
        for pair in &self.searched {
            take(pair, &mut rest, &mut found);
        }
        while rest.norm() > tolerance * norm {
            if self.searched.len() >= self.most {
                return None;
            }
            let (mut step, mut image) = search(&rest);
            let before = image.norm();
            // Twice, as the first pass leaves what rounding leaves.
            for (known, image_of_known) in self.searched.iter().chain(&self.searched) {
                let c = image.dot(image_of_known);
                image.add(-c, image_of_known);
                step.add(-c, known);
            }
            let length = image.norm();
            if !(length > f64::EPSILON * before && length.is_finite()) {
                return None;
            }
            image.scale(1.0 / length);
            step.scale(1.0 / length);
            let pair = (step, image);
            take(&pair, &mut rest, &mut found);
            self.searched.push(pair);
        }
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails may panic")]

    use super::*;

    impl Vector for Vec<f64> {
        fn add(&mut self, factor: f64, other: &Self) {
            self.iter_mut().zip(other).for_each(|(a, b)| *a += factor * b);
        }

        fn scale(&mut self, factor: f64) {
            self.iter_mut().for_each(|a| *a *= factor);
        }
    }

    impl Inner for Vec<f64> {
        fn dot(&self, other: &Self) -> f64 {
            self.iter().zip(other).map(|(a, b)| a * b).sum()
        }
    }

    #[test]
    fn later_right_hand_sides_use_what_was_searched() {
        let matrix = [[4.0, 1.0, 0.5], [-0.7, 3.0, 0.2], [0.1, -0.4, 2.0]];
        let product = |x: &Vec<f64>| -> Vec<f64> { matrix.iter().map(|row| row.to_vec().dot(x)).collect() };
        let counted = std::cell::Cell::new(0);
        let search = |rest: &Vec<f64>| {
            counted.set(counted.get() + 1);
            (rest.clone(), product(rest))
        };
        let mut solver = ConjugateResiduals::new(3);
        for right in [vec![1.0, 2.0, 3.0], vec![-1.0, 0.5, 0.0], vec![0.0; 3]] {
            let found = solver.solve(right.clone(), vec![0.0; 3], 1e-13, search).unwrap();
            for (a, b) in product(&found).iter().zip(&right) {
                assert!((a - b).abs() < 1e-12, "{found:?}");
            }
        }
        // Three directions span the space.
        assert_eq!(counted.get(), 3);
        let mut short = ConjugateResiduals::new(1);
        assert!(short.solve(vec![1.0, 2.0, 3.0], vec![0.0; 3], 1e-13, search).is_none());
    }
}
