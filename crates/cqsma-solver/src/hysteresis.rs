//! What a closed hysteresis loop says: frequency, damping, dissipation.

/// Vertices of one closed loop of modal force against modal amplitude.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Loop {
    /// Modal force at each vertex, `alpha` (sqrt(kg) m/s^2).
    pub force: Vec<f64>,
    /// Modal amplitude at each vertex, `q` (sqrt(kg) m).
    pub amplitude: Vec<f64>,
}

impl Loop {
    /// Area of the closed polygon, positive for dissipation (J); the sum is signed.
    pub fn area(&self) -> f64 {
        polygon(&self.force, &self.amplitude, 1)
    }

    /// Area from every second vertex: with [`Loop::area`] it tells how well the loop is resolved.
    ///
    /// `None` unless the number of edges is even.
    pub fn coarse_area(&self) -> Option<f64> {
        (self.force.len() % 2 == 1).then(|| polygon(&self.force, &self.amplitude, 2))
    }

    /// Smallest and largest modal amplitude.
    pub fn extremes(&self) -> (f64, f64) {
        self.amplitude
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), q| {
                (lo.min(*q), hi.max(*q))
            })
    }

    /// Distance between the last and the first vertex relative to the loop's range.
    pub fn closure(&self) -> f64 {
        let (low, high) = self.extremes();
        match (self.amplitude.first(), self.amplitude.last()) {
            (Some(first), Some(last)) => (last - first).abs() / (high - low),
            _ => 0.0,
        }
    }
}

/// `closed integral of force d amplitude` by trapezoids over every `stride`-th vertex.
fn polygon(force: &[f64], amplitude: &[f64], stride: usize) -> f64 {
    let vertices: Vec<usize> = (0..force.len()).step_by(stride).collect();
    let Some(&first) = vertices.first() else { return 0.0 };
    let next = vertices.iter().skip(1).chain(std::iter::once(&first));
    // Relative to the first vertex, so that the offset of a loop cannot enter through round-off.
    let at = |i: usize| (force[i] - force[first], amplitude[i] - amplitude[first]);
    vertices
        .iter()
        .zip(next)
        .map(|(&a, &b)| 0.5 * (at(a).0 + at(b).0) * (at(b).1 - at(a).1))
        .sum()
}
