//! Populations of asperity pairs: the distribution of their gaps with its partial moments, their number and radii.

use alloc::vec::Vec;

use crate::error::{Error, Place, require};
use crate::jet::Jet;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::{Bounds, Parameter, require_positive};

pub(crate) const DENSITY: Parameter = Parameter::new("asperity_density", "1/m^2", Bounds::Positive);
pub(crate) const BETA_X: Parameter = Parameter::new("beta_x", "m", Bounds::Positive);
pub(crate) const BETA_Y: Parameter = BETA_X.named("beta_y");

/// Distribution of the asperities' initial gaps `s` (m): pieces of uniform density, of which single samples are the
/// limit of zero width.
#[derive(Debug, Clone, PartialEq)]
pub struct GapDistribution {
    /// Ascending and without overlap.
    pieces: Vec<Piece>,
    /// Probability of all pieces before each piece.
    before: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    start: f64,
    width: f64,
    probability: f64,
}

impl GapDistribution {
    /// Equally weighted samples `s >= 0` (m) in any order.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a sample is negative or not finite, [`Error::Length`] when there is none.
    pub fn try_from_samples(mut samples: Vec<f64>) -> Result<Self, Error> {
        if samples.is_empty() {
            return Err(Error::Length {
                list: "asperity gap samples",
                expected: 1,
                found: 0,
            });
        }
        for (i, &s) in samples.iter().enumerate() {
            GAP.check_at(Place::Entry(i), s)?;
        }
        samples.sort_by(f64::total_cmp);
        let probability = 1.0 / samples.len() as f64;
        Ok(Self::from_pieces(
            samples
                .into_iter()
                .map(|start| Piece {
                    start,
                    width: 0.0,
                    probability,
                })
                .collect(),
        ))
    }

    /// Quantile function, linear between the given `probabilities` (ascending from 0 to 1) with the gaps `values` (m)
    /// (ascending, not negative). Equal neighbouring values put the probability between them on one gap.
    ///
    /// # Errors
    /// [`Error::Length`] when the lists differ in length or have fewer than two entries, [`Error::Parameter`] when an
    /// entry is not finite or out of order.
    pub fn try_from_quantiles(probabilities: &[f64], values: &[f64]) -> Result<Self, Error> {
        let n = probabilities.len();
        if n < 2 {
            return Err(Error::Length {
                list: "probabilities of the asperity gaps",
                expected: 2,
                found: n,
            });
        }
        if values.len() != n {
            return Err(Error::Length {
                list: "values of the asperity gaps",
                expected: n,
                found: values.len(),
            });
        }
        let (first, last) = (probabilities[0], probabilities[n - 1]);
        let probability = |at, text| Parameter::new("probability", "1", Bounds::Within([at; 2], text));
        probability(0.0, "0 for the first entry").check_at(Place::Entry(0), first)?;
        probability(1.0, "1 for the last entry").check_at(Place::Entry(n - 1), last)?;
        GAP.check_at(Place::Entry(0), values[0])?;
        let mut pieces = Vec::with_capacity(n - 1);
        for i in 1..n {
            GAP.check_at(Place::Entry(i), values[i])?;
            let (width, probability) = (values[i] - values[i - 1], probabilities[i] - probabilities[i - 1]);
            let requirement = "not below the entry before";
            require(
                width >= 0.0,
                "asperity gap",
                values[i],
                "m",
                Place::Entry(i),
                requirement,
            )?;
            require(
                probability >= 0.0,
                "probability",
                probabilities[i],
                "(no unit)",
                Place::Entry(i),
                requirement,
            )?;
            if probability > 0.0 {
                pieces.push(Piece {
                    start: values[i - 1],
                    width,
                    probability,
                });
            }
        }
        Ok(Self::from_pieces(pieces))
    }

    fn from_pieces(pieces: Vec<Piece>) -> Self {
        let before = pieces
            .iter()
            .scan(0.0, |sum, piece| {
                let before = *sum;
                *sum += piece.probability;
                Some(before)
            })
            .collect();
        Self { pieces, before }
    }

    /// The same distribution with all gaps multiplied by `factor`.
    fn scaled(&self, factor: f64) -> Self {
        let pieces = self.pieces.iter().map(|piece| Piece {
            start: piece.start * factor,
            width: piece.width * factor,
            ..*piece
        });
        Self {
            pieces: pieces.collect(),
            before: self.before.clone(),
        }
    }

    /// Gap of the first asperity to touch (m).
    pub fn smallest(&self) -> f64 {
        self.pieces[0].start
    }

    /// Gap of the last asperity to touch (m).
    pub fn largest(&self) -> f64 {
        let last = self.pieces[self.pieces.len() - 1];
        last.start + last.width
    }

    /// `M_0(u)`: probability of a gap below `u`.
    pub fn loaded_fraction(&self, u: f64) -> f64 {
        match self.n_loaded(u) {
            0 => 0.0,
            n => self.before[n - 1] + Loaded::new(&self.pieces[n - 1], u).share,
        }
    }

    /// `M_1(u) = E[(u - s)_+]` (m).
    pub fn mean_interference(&self, u: f64) -> f64 {
        self.loaded(u).map(|l| 0.5 * l.share * (l.a * l.a + l.b * l.b)).sum()
    }

    /// `M_{3/2}(u)` (m^(3/2)) and `M_{1/2}(u)` (m^(1/2)).
    pub fn three_halves_moment(&self, u: f64) -> (f64, f64) {
        self.loaded(u).fold((0.0, 0.0), |(high, low), l| {
            let (aa, ab, bb, sum) = (l.a * l.a, l.a * l.b, l.b * l.b, l.a + l.b);
            let quintic = aa * aa + ab * (aa + ab + bb) + bb * bb;
            (
                high + 0.4 * l.share * quintic / sum,
                low + 2.0 / 3.0 * l.share * (aa + ab + bb) / sum,
            )
        })
    }

    /// `M_{1/2}(u)` with its first two derivatives with respect to `u`.
    pub fn half_moment(&self, u: f64) -> Jet {
        self.loaded(u).fold(Jet::default(), |jet, l| {
            let sum = l.a + l.b;
            let bend = if l.partly {
                -l.density / l.a
            } else {
                l.share / (l.a * l.b * sum)
            };
            Jet {
                value: jet.value + 2.0 / 3.0 * l.share * (l.a * l.a + l.a * l.b + l.b * l.b) / sum,
                slope: jet.slope + l.share / sum,
                curvature: jet.curvature - 0.5 * bend,
            }
        })
    }

    /// Probability density of the gaps at `u` (1/m); zero between samples.
    pub(crate) fn density_at(&self, u: f64) -> f64 {
        match self.n_loaded(u) {
            0 => 0.0,
            n => Some(Loaded::new(&self.pieces[n - 1], u))
                .filter(|l| l.partly)
                .map_or(0.0, |l| l.density),
        }
    }

    /// Whether the first gaps are spread over a width rather than all the same.
    pub(crate) fn begins_with_a_width(&self) -> bool {
        self.pieces[0].width > 0.0
    }

    /// Start (m), width (m) and probability of every piece, ascending.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        self.pieces
            .iter()
            .map(|piece| (piece.start, piece.width, piece.probability))
    }

    /// Those of [`Self::pieces`] that may have gaps from `begin` to `end` (m).
    pub(crate) fn pieces_within(&self, begin: f64, end: f64) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let first = self.pieces.partition_point(|piece| piece.start + piece.width < begin);
        let after = self.pieces.partition_point(|piece| piece.start <= end).max(first);
        let pieces = self.pieces[first..after].iter();
        pieces.map(|piece| (piece.start, piece.width, piece.probability))
    }

    /// Number of pieces that begin below `u`.
    fn n_loaded(&self, u: f64) -> usize {
        self.pieces.partition_point(|piece| piece.start < u)
    }

    fn loaded(&self, u: f64) -> impl Iterator<Item = Loaded> + '_ {
        self.pieces[..self.n_loaded(u)]
            .iter()
            .map(move |piece| Loaded::new(piece, u))
    }
}

/// The part of a piece with gaps below `u`, from interference `b^2` to `a^2`.
///
/// Over it, `integral (u - s)^n ds = (a^(2n+2) - b^(2n+2))/(n + 1)`. Divided by the width `a^2 - b^2 = (a - b)(a + b)`,
/// the differences become sums of positive terms: no cancellation, and the limit of zero width is included.
struct Loaded {
    a: f64,
    b: f64,
    /// Probability of the part.
    share: f64,
    /// The piece reaches beyond `u`.
    partly: bool,
    /// Probability per gap, if `partly`.
    density: f64,
}

impl Loaded {
    #[inline]
    fn new(piece: &Piece, u: f64) -> Self {
        let interference = u - piece.start;
        let a = interference.sqrt();
        if interference <= piece.width {
            let density = piece.probability / piece.width;
            Self {
                a,
                b: 0.0,
                share: density * interference,
                partly: true,
                density,
            }
        } else {
            let b = (interference - piece.width).sqrt();
            Self {
                a,
                b,
                share: piece.probability,
                partly: false,
                density: 0.0,
            }
        }
    }
}

const GAP: Parameter = Parameter::new(
    "asperity gap",
    "m",
    Bounds::Within([0.0, f64::MAX], "finite and not negative: measure it from first touch"),
);

/// Asperity pairs of an area.
#[derive(Debug, Clone, PartialEq)]
pub struct AsperityPopulation {
    gaps: GapDistribution,
    density: f64,
    radii: [f64; 2],
}

impl AsperityPopulation {
    /// From the distribution of the initial gaps, the number of pairs per area `n_A` (1/m^2) and the pairs' effective
    /// radii `beta_x`, `beta_y` (m).
    ///
    /// # Errors
    /// [`Error::Parameter`] when density or radii are not above zero.
    pub fn try_new(gaps: GapDistribution, density: f64, radii: [f64; 2]) -> Result<Self, Error> {
        DENSITY.check(density)?;
        BETA_X.check(radii[0])?;
        BETA_Y.check(radii[1])?;
        Ok(Self { gaps, density, radii })
    }

    /// The population with its gaps, its density and both radii multiplied by factors.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a factor, or what it leaves, is not above zero and finite.
    pub fn scaled(&self, gaps: f64, density: f64, radii: f64) -> Result<Self, Error> {
        require_positive("factor of the asperity gaps", gaps, "(no unit)")?;
        GAP.check_at(Place::Entry(0), self.gaps.largest() * gaps)?;
        Self::try_new(
            self.gaps.scaled(gaps),
            self.density * density,
            self.radii.map(|beta| beta * radii),
        )
    }

    /// Distribution of the initial gaps.
    pub fn gaps(&self) -> &GapDistribution {
        &self.gaps
    }

    /// Pairs per area (1/m^2).
    pub fn density(&self) -> f64 {
        self.density
    }

    /// Effective radii along x and y (m).
    pub fn radii(&self) -> [f64; 2] {
        self.radii
    }

    /// `beta = sqrt(beta_x beta_y)` (m).
    pub fn effective_radius(&self) -> f64 {
        self.radii[0].sqrt() * self.radii[1].sqrt()
    }
}
