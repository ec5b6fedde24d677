//! Populations of asperities as a few bins, each of which stands for the asperities of an interval of gaps.

use crate::error::{Error, Place, require};
use crate::physics::elastic_plastic::Asperity;
use crate::physics::population::{AsperityPopulation, GapDistribution};
use alloc::vec::Vec;

/// Most bins of a population.
pub const MAX_BINS: usize = 1024;

/// Asperities per area in bins of one gap each.
#[derive(Debug, Clone, PartialEq)]
pub struct AsperityBins {
    asperity: Asperity,
    gaps: Vec<f64>,
    densities: Vec<f64>,
}

impl AsperityBins {
    /// From the gap (m, not negative, 0 is the first asperity to touch) and the asperities per area (1/m^2, not
    /// negative) of every bin.
    ///
    /// # Errors
    /// [`Error::Length`] when the lists differ in length, [`Error::Parameter`] when there are no bins or more than
    /// [`MAX_BINS`], or when an entry is negative or not finite.
    pub fn try_new(asperity: Asperity, gaps: Vec<f64>, densities: Vec<f64>) -> Result<Self, Error> {
        require_count(gaps.len())?;
        if densities.len() != gaps.len() {
            return Err(Error::Length {
                list: "asperity densities of the bins",
                expected: gaps.len(),
                found: densities.len(),
            });
        }
        for (name, unit, values) in [("bin_gap", "m", &gaps), ("bin_density", "1/m^2", &densities)] {
            for (i, &value) in values.iter().enumerate() {
                let ok = (0.0..=1e100).contains(&value);
                require(ok, name, value, unit, Place::Entry(i), "from 0 to 1e100")?;
            }
        }
        Ok(Self {
            asperity,
            gaps,
            densities,
        })
    }

    /// `n` equally spaced gaps from zero to the largest gap of a population; each has the asperities that are nearer to
    /// it than to another.
    ///
    /// # Errors
    /// [`Error::Parameter`] when `n` is not from 1 to [`MAX_BINS`].
    pub fn equally_spaced(asperity: Asperity, population: &AsperityPopulation, n: usize) -> Result<Self, Error> {
        require_count(n)?;
        let gaps = population.gaps();
        let spacing = gaps.largest() / (n.max(2) - 1) as f64;
        let edge = |j: usize| (j as f64 - 0.5) * spacing;
        let bins = (0..n).map(|j| {
            let below = if j == 0 { 0.0 } else { gaps.loaded_fraction(edge(j)) };
            let above = if j + 1 == n {
                1.0
            } else {
                gaps.loaded_fraction(edge(j + 1))
            };
            (j as f64 * spacing, (above - below) * population.density())
        });
        let (at, densities) = bins.unzip();
        Self::try_new(asperity, at, densities)
    }

    /// `n` bins that carry equal shares of the tangential stiffness, averaged over interferences up to `reach` (m); `shift`
    /// from 0 to 1 moves the limits between them by that share of a bin, and splits off what that leaves at the ends.
    /// Each bin has the asperities between its limits and their mean gap. Asperities with gaps beyond `reach` are one
    /// bin more.
    ///
    /// Neighbouring points with different shifts see different bins of the same population, so that their mean is as
    /// fine as all their bins together.
    ///
    /// # Errors
    /// [`Error::Parameter`] when `n` is not from 1 to [`MAX_BINS`] or when `reach` or `shift` is out of bounds.
    pub fn equally_stiff(
        asperity: Asperity,
        population: &AsperityPopulation,
        n: usize,
        reach: f64,
        shift: f64,
    ) -> Result<Self, Error> {
        require_count(n)?;
        let gaps = population.gaps();
        let ok = reach > gaps.smallest() && reach.is_finite();
        require(ok, "reach", reach, "m", Place::Whole, "above the smallest gap")?;
        require(
            (0.0..1.0).contains(&shift),
            "shift",
            shift,
            "(no unit)",
            Place::Whole,
            "from 0 to 1",
        )?;
        let share = StiffnessShare::new(gaps, reach);
        // The first limit is at the share `shift/n`; a shift of zero has none before the end of the first bin.
        let inner = (0..n).map(|j| (j as f64 + shift) / n as f64).filter(|&s| s > 0.0);
        let mut limits: Vec<f64> = inner.map(|s| share.gap_at(s)).collect();
        limits.push(reach.min(gaps.largest()));
        if gaps.largest() > reach {
            limits.push(gaps.largest());
        }
        let mut bins = Vec::with_capacity(n + 2);
        let mut below = (0.0, 0.0);
        for limit in limits {
            // Probability, and probability times mean gap, of all gaps up to the limit.
            let probability = gaps.loaded_fraction(next_up(limit));
            let upto = (probability, limit * probability - gaps.mean_interference(limit));
            let mass = upto.0 - below.0;
            if mass > 0.0 {
                bins.push(((upto.1 - below.1) / mass, mass * population.density()));
                below = upto;
            }
        }
        let (at, densities) = bins
            .into_iter()
            .map(|(gap, density): (f64, f64)| (gap.max(0.0), density))
            .unzip();
        Self::try_new(asperity, at, densities)
    }

    /// What an asperity of any bin does.
    pub fn asperity(&self) -> &Asperity {
        &self.asperity
    }

    /// Gaps (m).
    pub fn gaps(&self) -> &[f64] {
        &self.gaps
    }

    /// Asperities per area (1/m^2).
    pub fn densities(&self) -> &[f64] {
        &self.densities
    }

    /// Number of bins.
    pub fn len(&self) -> usize {
        self.gaps.len()
    }

    /// False: there is at least one bin.
    pub fn is_empty(&self) -> bool {
        self.gaps.is_empty()
    }
}

fn require_count(n: usize) -> Result<(), Error> {
    let ok = (1..=MAX_BINS).contains(&n);
    require(ok, "bins", n as f64, "(no unit)", Place::Whole, "from 1 to 1024")
}

/// The next larger number: gaps at a limit belong below it.
fn next_up(x: f64) -> f64 {
    if x > 0.0 {
        f64::from_bits(x.to_bits() + 1)
    } else {
        f64::MIN_POSITIVE
    }
}

/// The share of the tangential stiffness that asperities up to a gap carry, averaged over interferences.
struct StiffnessShare {
    gaps: Vec<f64>,
    /// Rises from 0 to 1.
    shares: Vec<f64>,
}

/// Gaps at which the share is tabulated, and interferences it is averaged over: both only place the limits between bins.
const GRID: usize = 512;
const INTERFERENCES: usize = 24;

impl StiffnessShare {
    fn new(gaps: &GapDistribution, reach: f64) -> Self {
        let at: Vec<f64> = (0..=GRID).map(|i| reach * i as f64 / GRID as f64).collect();
        let mut density = alloc::vec![0.0; GRID];
        for k in 1..=INTERFERENCES {
            let u = reach * k as f64 / INTERFERENCES as f64;
            let mut shares: Vec<f64> = Vec::with_capacity(GRID);
            for i in 0..GRID {
                let mass = gaps.loaded_fraction(at[i + 1]) - gaps.loaded_fraction(at[i]);
                let beyond = u - 0.5 * (at[i] + at[i + 1]);
                shares.push(if beyond > 0.0 { mass * root(beyond) } else { 0.0 });
            }
            let sum: f64 = shares.iter().sum();
            if sum > 0.0 {
                for (density, share) in density.iter_mut().zip(&shares) {
                    *density += share / sum;
                }
            }
        }
        let total: f64 = density.iter().sum();
        let mut sum = 0.0;
        let mut shares = alloc::vec![0.0];
        shares.extend(density.iter().map(|d| {
            sum += d;
            if total > 0.0 { sum / total } else { 0.0 }
        }));
        Self { gaps: at, shares }
    }

    /// The gap up to which asperities carry a share.
    fn gap_at(&self, share: f64) -> f64 {
        let i = self
            .shares
            .partition_point(|&s| s < share)
            .clamp(1, self.shares.len() - 1);
        let (low, high) = (self.shares[i - 1], self.shares[i]);
        let part = if high > low { (share - low) / (high - low) } else { 1.0 };
        self.gaps[i - 1] + part.clamp(0.0, 1.0) * (self.gaps[i] - self.gaps[i - 1])
    }
}

fn root(x: f64) -> f64 {
    #[cfg(not(feature = "std"))]
    use crate::math::Float as _;
    x.sqrt()
}
