//! Empirical quadrature: a few points with weights that are not negative.

use faer::MatRef;

/// Squared length of a column outside the span of those selected, relative to its own, that is round-off.
const DEPENDENT: f64 = 1e-12;

/// Outer steps per column that may be selected. The method ends by itself; this guards against round-off.
const STEPS: usize = 4;

/// Columns with their weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Columns, ascending.
    pub columns: Vec<usize>,
    /// Weight of each, positive.
    pub weights: Vec<f64>,
    /// Distance of their combination from the target, relative to the target.
    pub residual: f64,
}

/// At most `most` columns and positive weights with which they add up to `target`, up to `tolerance` (relative, Euclidean norm).
///
/// The active-set method of Lawson and Hanson (*Solving Least Squares Problems*, 1974, chapter 23), ended early: as in the energy-conserving
/// sampling of Farhat, Chapman and Avery (2015, DOI 10.1002/nme.4820), what it has selected by then is the reduced mesh.
///
/// # Panics
/// If the target is not as long as a column.
pub fn select(columns: MatRef<'_, f64>, target: &[f64], most: usize, tolerance: f64) -> Selection {
    assert_eq!(columns.nrows(), target.len());
    let n = columns.ncols();
    let lengths: Vec<f64> = (0..n).map(|j| columns.col(j).iter().map(|a| a * a).sum()).collect();
    // Selected, or of no use.
    let mut is_out: Vec<bool> = lengths.iter().map(|length| *length == 0.0).collect();
    let mut set = PassiveSet {
        columns,
        target,
        members: Vec::new(),
        weights: Vec::new(),
        gram: Vec::new(),
        factor: Vec::new(),
        right: Vec::new(),
    };
    let norm = norm(target);
    let mut residual = target.to_vec();
    for _ in 0..STEPS * most {
        if self::norm(&residual) <= tolerance * norm || set.members.len() >= most {
            break;
        }
        let gain = |j: usize| dot(columns, j, &residual) / lengths[j].sqrt();
        let candidates = (0..n).filter(|j| !is_out[*j]).map(|j| (j, gain(j)));
        let best = candidates.max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((entering, _)) = best.filter(|(_, gain)| *gain > f64::EPSILON * norm) else {
            break;
        };
        is_out[entering] = true;
        if !set.add(entering) {
            continue;
        }
        for leaving in set.settle() {
            // A column that leaves at once would enter again at once.
            is_out[leaving] = leaving == entering;
        }
        residual = set.residual();
    }
    let mut found: Vec<(usize, f64)> = set.members.iter().copied().zip(set.weights.iter().copied()).collect();
    found.sort_by_key(|(column, _)| *column);
    let (columns, weights) = found.into_iter().unzip();
    Selection {
        columns,
        weights,
        residual: if norm == 0.0 { 0.0 } else { self::norm(&residual) / norm },
    }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn dot(columns: MatRef<'_, f64>, j: usize, v: &[f64]) -> f64 {
    columns.col(j).iter().zip(v).map(|(a, b)| a * b).sum()
}

/// The columns whose weights are not held at zero.
struct PassiveSet<'a> {
    columns: MatRef<'a, f64>,
    target: &'a [f64],
    members: Vec<usize>,
    weights: Vec<f64>,
    /// Products of each member with itself and those before it.
    gram: Vec<Vec<f64>>,
    /// Rows of the Cholesky factor of the products.
    factor: Vec<Vec<f64>>,
    /// Products with the target.
    right: Vec<f64>,
}

impl PassiveSet<'_> {
    /// Adds a column with weight zero, unless those there already span it.
    fn add(&mut self, column: usize) -> bool {
        let own: Vec<f64> = self.columns.col(column).iter().copied().collect();
        let members = self.members.iter().chain([&column]);
        self.gram
            .push(members.map(|member| dot(self.columns, *member, &own)).collect());
        let is_independent = self.extend_factor();
        if is_independent {
            self.right.push(dot(self.columns, column, self.target));
            self.members.push(column);
            self.weights.push(0.0);
        } else {
            self.gram.pop();
        }
        is_independent
    }

    /// The next row of the factor, if it has one.
    fn extend_factor(&mut self) -> bool {
        let at = self.factor.len();
        let products = &self.gram[at];
        let mut row: Vec<f64> = Vec::with_capacity(at + 1);
        for (k, known) in self.factor.iter().enumerate() {
            let sum: f64 = row.iter().zip(known).map(|(a, b)| a * b).sum();
            row.push((products[k] - sum) / known[k]);
        }
        let rest = products[at] - row.iter().map(|r| r * r).sum::<f64>();
        let is_independent = rest > DEPENDENT * products[at];
        if is_independent {
            row.push(rest.sqrt());
            self.factor.push(row);
        }
        is_independent
    }

    /// Weights of least squares, whatever their signs.
    fn least_squares(&self) -> Vec<f64> {
        let k = self.factor.len();
        let mut x = self.right.clone();
        for i in 0..k {
            let sum: f64 = self.factor[i][..i].iter().zip(&x).map(|(a, b)| a * b).sum();
            x[i] = (x[i] - sum) / self.factor[i][i];
        }
        for i in (0..k).rev() {
            x[i] /= self.factor[i][i];
            let (solved, own) = (x[i], &self.factor[i][..i]);
            x[..i].iter_mut().zip(own).for_each(|(x, l)| *x -= l * solved);
        }
        x
    }

    /// Goes to the weights of least squares, and drops members on the way whose weights would become negative; these are returned.
    fn settle(&mut self) -> Vec<usize> {
        let mut dropped = Vec::new();
        loop {
            let wanted = self.least_squares();
            // How far along the way the first weight vanishes.
            let vanishes = |(at, (now, goal)): (usize, (&f64, &f64))| {
                let part = if *now > 0.0 { now / (now - goal) } else { 0.0 };
                (*goal <= 0.0).then_some((at, part))
            };
            let first = self.weights.iter().zip(&wanted).enumerate().filter_map(vanishes);
            let Some((at, part)) = first.min_by(|a, b| a.1.total_cmp(&b.1)) else {
                self.weights = wanted;
                return dropped;
            };
            for (now, goal) in self.weights.iter_mut().zip(&wanted) {
                *now += part * (goal - *now);
            }
            self.remove(at, &mut dropped);
        }
    }

    /// Removes a member, and those that round-off then makes part of the span of the others.
    fn remove(&mut self, at: usize, dropped: &mut Vec<usize>) {
        let mut next = Some(at);
        while let Some(at) = next {
            self.weights.remove(at);
            self.right.remove(at);
            self.gram.remove(at);
            for row in &mut self.gram[at..] {
                row.remove(at);
            }
            self.factor.truncate(at);
            dropped.push(self.members.remove(at));
            next = None;
            while next.is_none() && self.factor.len() < self.gram.len() {
                if !self.extend_factor() {
                    next = Some(self.factor.len());
                }
            }
        }
    }

    fn residual(&self) -> Vec<f64> {
        let mut residual = self.target.to_vec();
        for (&member, weight) in self.members.iter().zip(&self.weights) {
            let column = self.columns.col(member);
            residual
                .iter_mut()
                .zip(column.iter())
                .for_each(|(r, c)| *r -= weight * c);
        }
        residual
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dense_algebra::scattered;
    use faer::Mat;

    #[test]
    fn polynomials_are_integrated_by_as_few_points_as_there_are_conditions() {
        // Legendre polynomials up to degree 9 at 400 midpoints of [-1, 1], whose sum is the integral.
        let (m, n) = (10, 400);
        let legendre = |degree: usize, x: f64| {
            let (mut before, mut now) = (1.0, x);
            for k in 1..degree {
                let k = k as f64;
                (before, now) = (now, ((2.0 * k + 1.0) * x * now - k * before) / (k + 1.0));
            }
            if degree == 0 { 1.0 } else { now }
        };
        let x = |p: usize| (2.0 * p as f64 + 1.0) / n as f64 - 1.0;
        let columns = Mat::from_fn(m, n, |i, p| legendre(i, x(p)));
        let target: Vec<f64> = (0..m).map(|i| (0..n).map(|p| columns[(i, p)]).sum()).collect();
        let found = select(columns.as_ref(), &target, n, 1e-10);
        assert!(found.residual <= 1e-10 && found.columns.len() <= m, "{found:?}");
        assert!(found.weights.iter().all(|w| *w > 0.0) && found.columns.is_sorted());
        // As many as allowed, and no more.
        let few = select(columns.as_ref(), &target, 4, 1e-10);
        assert_eq!(few.columns.len(), 4);
        assert!(few.residual > 1e-10);
    }

    #[test]
    fn least_squares_that_need_no_sign_are_found_and_the_conditions_of_the_others_hold() {
        let (m, n) = (40, 25);
        let columns = scattered(m, n);
        let mixed: Vec<f64> = (0..m)
            .map(|i| {
                (0..n)
                    .map(|j| columns[(i, j)] * if j % 3 == 0 { -1.0 } else { 1.0 })
                    .sum()
            })
            .collect();
        let found = select(columns.as_ref(), &mixed, n, 1e-14);
        // Karush, Kuhn and Tucker: no gradient along what is selected, and none that would gain elsewhere.
        let mut residual = mixed;
        for (&j, w) in found.columns.iter().zip(&found.weights) {
            residual
                .iter_mut()
                .zip(columns.col(j).iter())
                .for_each(|(r, c)| *r -= w * c);
        }
        for j in 0..n {
            let gradient = dot(columns.as_ref(), j, &residual);
            match found.columns.contains(&j) {
                true => assert!(gradient.abs() < 1e-12, "{j}: {gradient}"),
                false => assert!(gradient < 1e-12, "{j}: {gradient}"),
            }
        }
        assert!(found.columns.len() < n);
    }
}
