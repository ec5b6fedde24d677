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

/// Minimal residuals with all that was searched kept: what served one right-hand side serves the next ones too.
#[derive(Clone, Debug)]
pub struct ConjugateResiduals<S, R> {
    /// Steps as they were searched.
    steps: Vec<S>,
    /// Their images under the operator, made orthonormal one after the other.
    images: Vec<R>,
    /// What each image was of those up to its own.
    mixtures: Vec<Vec<f64>>,
    most: usize,
}

/// An image whose part outside of those before is shorter than this, relative to it, is made orthogonal once more: round-off is left in it.
const LOST: f64 = 0.5;

/// A rest shorter than this, relative to when it was last renewed, is renewed.
const WORN: f64 = 1e-4;

impl<S: Vector, R: Inner> ConjugateResiduals<S, R> {
    /// Keeps at most `most` directions.
    pub fn new(most: usize) -> Self {
        Self {
            steps: Vec::new(),
            images: Vec::new(),
            mixtures: Vec::new(),
            most,
        }
    }

    /// How many directions were searched.
    pub fn searched(&self) -> usize {
        self.steps.len()
    }

    /// Adds to `found` the step whose image is `rest`. `search` gives the next step for what is left, and its image, or nothing more. `renew` computes the
    /// parts of what is left that follow from others: their round-off is that of the start, large beside a small rest, and steps of small rests are
    /// multiplied by large numbers for later right-hand sides. `None` if `tolerance` (relative) is not reached.
    pub fn solve(
        &mut self,
        mut rest: R,
        mut found: S,
        tolerance: f64,
        renew: impl Fn(&mut R),
        search: impl Fn(&R) -> Option<(S, R)>,
    ) -> Option<S> {
        let norm = rest.norm();
        let mut renewed = norm;
        let mut along = self.take_known(&mut rest);
        while rest.norm() > tolerance * norm {
            if self.steps.len() >= self.most {
                return None;
            }
            if rest.norm() < WORN * renewed {
                renew(&mut rest);
                renewed = rest.norm();
            }
            let (step, image) = search(&rest)?;
            if !self.keep(step, image, f64::EPSILON) {
                return None;
            }
            along.push(take(&self.images[along.len()], &mut rest));
        }
        self.combine(along, &mut found);
        Some(found)
    }

    /// Takes off `rest` what images of kept directions make of it, and adds their steps to `found`.
    pub fn fit(&self, rest: &mut R, found: &mut S) {
        let along = self.take_known(rest);
        self.combine(along, found);
    }

    /// Keeps a step and its image, unless the image's part outside of those kept is not longer than `share` of it.
    pub fn keep(&mut self, step: S, mut image: R, share: f64) -> bool {
        let before = image.norm();
        let mut mixture = vec![0.0; self.images.len()];
        let mut length = before;
        for _ in 0..2 {
            for (known, c) in self.images.iter().zip(&mut mixture) {
                *c += take(known, &mut image);
            }
            let outside = image.norm();
            let is_clean = outside > LOST * length;
            length = outside;
            if is_clean {
                break;
            }
        }
        if !(length > share * before && length.is_finite()) {
            return false;
        }
        image.scale(1.0 / length);
        mixture.push(length);
        self.steps.push(step);
        self.images.push(image);
        self.mixtures.push(mixture);
        true
    }

    fn take_known(&self, rest: &mut R) -> Vec<f64> {
        self.images.iter().map(|image| take(image, rest)).collect()
    }

    /// Adds the steps whose images are the orthonormal ones times `along`.
    fn combine(&self, mut along: Vec<f64>, found: &mut S) {
        for at in (0..self.steps.len()).rev() {
            let mixture = &self.mixtures[at];
            let factor = along[at] / mixture[at];
            for (along, c) in along.iter_mut().zip(&mixture[..at]) {
                *along -= factor * c;
            }
            found.add(factor, &self.steps[at]);
        }
    }
}

/// Takes off `rest` its part along an image of unit length; how long that is.
fn take<R: Inner>(image: &R, rest: &mut R) -> f64 {
    let along = rest.dot(image);
    rest.add(-along, image);
    along
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
            Some((rest.clone(), product(rest)))
        };
        let mut solver = ConjugateResiduals::new(3);
        for right in [vec![1.0, 2.0, 3.0], vec![-1.0, 0.5, 0.0], vec![0.0; 3]] {
            let found = solver
                .solve(right.clone(), vec![0.0; 3], 1e-13, |_| (), search)
                .unwrap();
            for (a, b) in product(&found).iter().zip(&right) {
                assert!((a - b).abs() < 1e-12, "{found:?}");
            }
        }
        // Three directions span the space.
        assert_eq!(counted.get(), 3);
        // What is known of a right-hand side needs no search, and says nothing new.
        let (mut rest, mut found) = (vec![2.0, -1.0, 0.5], vec![0.0; 3]);
        solver.fit(&mut rest, &mut found);
        assert!(rest.norm() < 1e-12);
        for (a, b) in product(&found).iter().zip([2.0, -1.0, 0.5]) {
            assert!((a - b).abs() < 1e-12, "{found:?}");
        }
        assert!(!solver.keep(found.clone(), product(&found), 1e-9));
        let mut short = ConjugateResiduals::new(1);
        assert!(
            short
                .solve(vec![1.0, 2.0, 3.0], vec![0.0; 3], 1e-13, |_| (), search)
                .is_none()
        );
    }

    /// A force with what a diagonal stiffness answers.
    #[derive(Clone)]
    struct Answered {
        force: Vec<f64>,
        response: Vec<f64>,
    }

    impl Vector for Answered {
        fn add(&mut self, factor: f64, other: &Self) {
            self.force.add(factor, &other.force);
            self.response.add(factor, &other.response);
        }

        fn scale(&mut self, factor: f64) {
            self.force.scale(factor);
            self.response.scale(factor);
        }
    }

    impl Inner for Answered {
        fn dot(&self, other: &Self) -> f64 {
            self.force.dot(&other.response)
        }
    }

    #[test]
    fn steps_of_small_rests_serve_later_right_hand_sides() {
        let n = 30;
        let stiffness: Vec<f64> = (0..n).map(|i| 7f64.powi(-(i as i32 % 12))).collect();
        let answer = |force: &[f64]| -> Vec<f64> { force.iter().zip(&stiffness).map(|(p, k)| p / k).collect() };
        let answered = |force: Vec<f64>| Answered {
            response: answer(&force),
            force,
        };
        // Springs beside the stiffness, a hundredth of it.
        let springs = |v: &[f64], i: usize| {
            let next = (i + 1) % n;
            1e-2 * (stiffness[i] * stiffness[next]).sqrt() * v[next] + 1e-2 * stiffness[i] * (i % 3) as f64 * v[i]
        };
        let search = |rest: &Answered| {
            let image = (0..n).map(|i| rest.force[i] + springs(&rest.response, i));
            Some((rest.clone(), answered(image.collect())))
        };
        let renew = |rest: &mut Answered| rest.response = answer(&rest.force);
        let mut solver = ConjugateResiduals::new(100);
        for right in 0..4 {
            let force = (0..n).map(|i| ((3 * i + 7 * right) as f64).sin() * stiffness[i].sqrt());
            let right = answered(force.collect());
            let none = answered(vec![0.0; n]);
            let found = solver.solve(right.clone(), none, 1e-12, renew, search).unwrap();
            let image = (0..n).map(|i| stiffness[i] * found.response[i] + springs(&found.response, i));
            let mut left = answered(image.collect());
            left.add(-1.0, &right);
            // 3e-8 if rests are not renewed.
            assert!(left.norm() < 3e-12 * right.norm(), "{:e}", left.norm() / right.norm());
        }
    }
}
