//! Tabulated contact curves: monotone cubic Hermite interpolation of any other curves, C1, with the largest relative
//! error measured when the table is made.
//!
//! `m` knots lie evenly within each octave of the interference, so their relative distance is between `1/m` and
//! `1/(2m)` everywhere, results do not depend on the unit of length, and the cell of a `u_n` is read off the bits of
//! `u_n/u_lower` without a search or a logarithm. In each cell, of width `h`, the curve is the cubic with the values
//! `f` and slopes `f'` of its knots:
//! <div>
//! $$ u_{ji} = u_\text{lower} \, 2^j \left( 1 + \frac{i}{m} \right), \quad i = 0, \dots, m - 1, \qquad
//! s = \frac{u_n - u_0}{h} \in [0, 1], $$
//! </div>
//! <div>
//! $$ f(u_n) = f_0 + h f_0' \, s + \left( 3 \Delta - h (2 f_0' + f_1') \right) s^2
//! + \left( h (f_0' + f_1') - 2 \Delta \right) s^3, \qquad \Delta = f_1 - f_0 . $$
//! </div>
//!
//! The slopes are the source's, limited where the interpolant would otherwise not be monotone: at most three times the
//! smaller neighbouring secant. Derivatives are those of the interpolant. Smooth sources are met with fourth order in
//! `1/m`.
//!
//! The error is measured at eight points of each cell, as the deviation from the source divided by the source's value
//! at the cell's upper knot; `m` is doubled from 4 until the tolerances hold.
//!
//! # Outside the table
//! With the value `f_e` and the log-slope `g` at an end `u_e`, `v = u_n/u_e`, and the source's
//! [exponents](crate::Exponents) `p`, C1 at both ends:
//! <div>
//! $$ f = f_e \, v^{p} \, e^{(g - p)(v - 1)} \quad (v < 1), \qquad f = f_e \, v^{g} \quad (v > 1) . $$
//! </div>
//!
//! A curve that is zero at the lower end is zero below it.
//!
//! # Parameters
//! | parameter | unit | default |
//! |---|---|---|
//! | range of interferences | m | |
//! | `tolerance_normal`, largest relative error of `t_n` | 1 | 1e-5 |
//! | `tolerance_tangential`, largest relative error of `k_x`, `k_y` | 1 | 1e-4 |
//! | `max_knots_per_octave`, a power of two | 1 | 1024 |
//! | friction coefficient `mu` | 1 | |
//!
//! Source: F. N. Fritsch and R. E. Carlson, *Monotone piecewise cubic interpolation*, SIAM J. Numer. Anal. 17, 1980;
//! the limit on the slopes: C. de Boor and B. Swartz, *Piecewise monotone interpolation*, J. Approx. Theory 21, 1977.
//!
//! # Example
//! ```
//! use contact_laws::*;
//!
//! // Half of the asperities touch within 5 um.
//! let gaps = GapDistribution::try_from_quantiles(&[0.0, 0.5, 1.0], &[0.0, 5e-6, 2e-5])?;
//! let population = AsperityPopulation::try_new(gaps, 1.4e6, [1.4e-3; 2])?;
//! let exact = AsperitySumCurves::try_new(population, ElasticPair::new(192.85e9, 0.29), TangentialReading::Mindlin)?;
//! let table = Tabulated::try_new(exact, [1e-8, 5e-5], TableOptions::default())?;
//! println!("{} knots, error {:.1e}", table.n_knots(), table.max_relative_error_normal());
//! let deviation = table.normal(3.3e-6).0 / table.source().normal(3.3e-6).0 - 1.0;
//! assert!(deviation.abs() <= 1e-5);
//!
//! // 15 000 points that share it.
//! let (curves, mu) = (PointParameters::uniform(table, 15_000), PointParameters::uniform(0.2, 15_000));
//! let law = TableLaw::try_new(curves, mu, HistoryRule::Incremental)?;
//! assert_eq!(law.len(), 15_000);
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use alloc::vec::Vec;

use crate::curves::continuation::End;
use crate::curves::{ContactCurves, CurveFactors, CurvesInfo, Exponents};
use crate::error::{Error, Place, require};
use crate::jet::Jet;
use crate::law::PAPER_DOI;
use crate::parameters::{Bounds, Parameter, require_positive};

const AT_KNOTS: Bounds = Bounds::Other("finite and not negative at every knot of a table, with a slope");

pub(super) static INFO: CurvesInfo = CurvesInfo {
    name: "tabulated contact curves",
    reference: PAPER_DOI,
    page: "table.md",
    parameters: &[
        Parameter::new("u_n", "m", Bounds::Other("at the knots of a range")),
        Parameter::new("t_n", "Pa", AT_KNOTS),
        Parameter::new("k_x", "Pa/m", AT_KNOTS),
        Parameter::new("k_y", "Pa/m", AT_KNOTS),
    ],
};

/// How fine a table is made.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct TableOptions {
    /// Largest relative error of the normal traction.
    pub tolerance_normal: f64,
    /// Largest relative error of the tangential stiffnesses. Populations given by samples have a kink of square-root
    /// type at every sample: a few per mille is what a table can reach there.
    pub tolerance_tangential: f64,
    /// Most knots per octave, a power of two. The table begins with few and doubles them until both tolerances hold.
    pub max_knots_per_octave: u32,
}

impl Default for TableOptions {
    fn default() -> Self {
        Self {
            tolerance_normal: 1e-5,
            tolerance_tangential: 1e-4,
            max_knots_per_octave: 1024,
        }
    }
}

/// The tabulated curves.
const CURVES: [&str; 3] = ["t_n", "k_x", "k_y"];
/// Points per cell at which the error is measured.
const N_CHECKS: u32 = 8;
/// Knots per octave of the coarsest table.
const COARSEST: u32 = 4;

/// A table of the curves `C`, which it keeps for what is not tabulated (contact area, yield).
#[derive(Debug, Clone, PartialEq)]
pub struct Tabulated<C> {
    source: C,
    grid: Grid,
    /// Coefficients per cell of the normal traction in the cell's coordinate, from the constant up.
    normal: Vec<[f64; 4]>,
    /// The same for x and y.
    tangential: Vec<[[f64; 4]; 2]>,
    normal_ends: [End; 2],
    tangential_ends: [[End; 2]; 2],
    exponents: Exponents,
    max_relative_error_normal: f64,
    max_relative_error_tangential: f64,
}

impl<C: ContactCurves> Tabulated<C> {
    /// A table of `source` over the interferences `range` (m), refined until the tolerances of `options` hold.
    ///
    /// The relative error at a point is the deviation divided by the curve's value at the upper knot of the point's
    /// cell, which is finite also where a curve begins at zero.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a range or option out of bounds or a source that is not finite in the range,
    /// [`Error::NotMonotone`] for a source that falls, [`Error::Tolerance`] when the finest table allowed is not good
    /// enough.
    pub fn try_new(source: C, range: [f64; 2], options: TableOptions) -> Result<Self, Error> {
        let [lower, upper] = range;
        let normal_number = |u: f64| u.is_normal() && u > 0.0 && (1.0 / u).is_normal();
        require(
            normal_number(lower),
            "table range, lower end",
            lower,
            "m",
            Place::Whole,
            "a positive normal number",
        )?;
        let ok = normal_number(upper) && upper > lower && (upper / lower).is_finite();
        require(
            ok,
            "table range, upper end",
            upper,
            "m",
            Place::Whole,
            "finite and above the lower end",
        )?;
        require_positive("tolerance_normal", options.tolerance_normal, "(no unit)")?;
        require_positive("tolerance_tangential", options.tolerance_tangential, "(no unit)")?;
        let most = options.max_knots_per_octave;
        let ok = most.is_power_of_two() && (COARSEST..=1 << 16).contains(&most);
        require(
            ok,
            "max_knots_per_octave",
            most.into(),
            "(no unit)",
            Place::Whole,
            "a power of two from 4 to 65536",
        )?;

        let mut knots = COARSEST;
        loop {
            let table = Curves::tabulate(&source, Grid::new(lower, upper, knots))?;
            let errors = table.measure(&source);
            let tolerances = [
                options.tolerance_normal,
                options.tolerance_tangential,
                options.tolerance_tangential,
            ];
            match (0..3).find(|&i| errors[i].error > tolerances[i]) {
                None => return Ok(Self::from_curves(source, &table, errors)),
                Some(i) if knots == most => {
                    return Err(Error::Tolerance {
                        curve: CURVES[i],
                        interference: errors[i].interference,
                        error: errors[i].error,
                        tolerance: tolerances[i],
                        knots_per_octave: knots,
                    });
                }
                Some(_) => knots *= 2,
            }
        }
    }

    fn from_curves(source: C, table: &Curves, errors: [Worst; 3]) -> Self {
        let exponents = source.exponents();
        let ends = table.knots.each_ref().map(|knots| table.ends(knots));
        let cells = 0..table.grid.n_cells;
        let [n, x, y] = &table.knots;
        Self {
            source,
            normal: cells.clone().map(|cell| table.grid.cubic(cell, n)).collect(),
            tangential: cells
                .map(|cell| [table.grid.cubic(cell, x), table.grid.cubic(cell, y)])
                .collect(),
            normal_ends: ends[0],
            tangential_ends: [ends[1], ends[2]],
            exponents,
            max_relative_error_normal: errors[0].error,
            max_relative_error_tangential: errors[1].error.max(errors[2].error),
            grid: table.grid,
        }
    }

    /// The table of `source`, whose curves are those of this table's source with interferences and values multiplied by factors:
    /// `t_n(u_n) = f_n t_n0(u_n / f_u)`, and so on. Nothing is tabulated anew, so that the table changes smoothly with the factors.
    ///
    /// # Errors
    /// [`Error::Parameter`] for factors that are not positive and finite.
    pub fn scaled(&self, source: C, factors: CurveFactors) -> Result<Self, Error> {
        factors.validate()?;
        let CurveFactors {
            interference,
            normal,
            tangential,
        } = factors;
        let lower = self.grid.lower * interference;
        let end = |end: End, value: f64| end.scaled(interference, value);
        Ok(Self {
            source,
            grid: Grid {
                lower,
                per_lower: 1.0 / lower,
                ..self.grid
            },
            normal: self.normal.iter().map(|cell| cell.map(|c| c * normal)).collect(),
            tangential: self
                .tangential
                .iter()
                .map(|cell| core::array::from_fn(|q| cell[q].map(|c| c * tangential[q])))
                .collect(),
            normal_ends: self.normal_ends.map(|of| end(of, normal)),
            tangential_ends: core::array::from_fn(|q| self.tangential_ends[q].map(|of| end(of, tangential[q]))),
            ..*self
        })
    }

    /// The curves that were tabulated.
    pub fn source(&self) -> &C {
        &self.source
    }

    /// Interferences between which the table interpolates (m): the range asked for, rounded up to a knot.
    pub fn range(&self) -> [f64; 2] {
        [self.grid.knot(0), self.grid.knot(self.grid.n_cells)]
    }

    /// Number of knots.
    pub fn n_knots(&self) -> usize {
        self.grid.n_cells + 1
    }

    /// Largest relative error of the normal traction found within the range.
    pub fn max_relative_error_normal(&self) -> f64 {
        self.max_relative_error_normal
    }

    /// Largest relative error of the tangential stiffnesses found within the range.
    pub fn max_relative_error_tangential(&self) -> f64 {
        self.max_relative_error_tangential
    }
}

impl<C: ContactCurves> ContactCurves for Tabulated<C> {
    fn info(&self) -> &'static CurvesInfo {
        &INFO
    }

    #[inline]
    fn normal(&self, u_n: f64) -> (f64, f64) {
        let t = match self.grid.locate(u_n) {
            Location::Below => self.normal_ends[0].below(u_n, self.exponents.normal),
            Location::Above => self.normal_ends[1].above(u_n),
            Location::Cell { cell, s, per_width } => evaluate(&self.normal[cell], s, per_width),
        };
        (t.value, t.slope)
    }

    #[inline]
    fn tangential(&self, u_n: f64) -> [Jet; 2] {
        match self.grid.locate(u_n) {
            Location::Below => {
                core::array::from_fn(|q| self.tangential_ends[q][0].below(u_n, self.exponents.tangential[q]))
            }
            Location::Above => self.tangential_ends.map(|ends| ends[1].above(u_n)),
            Location::Cell { cell, s, per_width } => {
                let [x, y] = &self.tangential[cell];
                [evaluate(x, s, per_width), evaluate(y, s, per_width)]
            }
        }
    }

    fn exponents(&self) -> Exponents {
        self.exponents
    }

    fn contact_area_ratio(&self, u_n: f64) -> Option<f64> {
        self.source.contact_area_ratio(u_n)
    }

    fn yielded_fraction(&self, u_n: f64, omega_c: f64) -> Option<f64> {
        self.source.yielded_fraction(u_n, omega_c)
    }
}

/// A cell's cubic at `s` in 0..1.
#[inline(always)]
fn evaluate(c: &[f64; 4], s: f64, per_width: f64) -> Jet {
    Jet {
        value: c[0] + s * (c[1] + s * (c[2] + s * c[3])),
        slope: per_width * (c[1] + s * (2.0 * c[2] + s * 3.0 * c[3])),
        curvature: per_width * per_width * (2.0 * c[2] + 6.0 * s * c[3]),
    }
}

/// Knots `lower * v_i`, where the bit patterns of the `v_i >= 1` are equally spaced.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grid {
    lower: f64,
    per_lower: f64,
    /// Logarithm to base 2 of the knots per octave.
    bits: u32,
    n_cells: usize,
}

/// Where an interference lies in a table.
enum Location {
    Below,
    Cell { cell: usize, s: f64, per_width: f64 },
    Above,
}

const MANTISSA_BITS: u32 = f64::MANTISSA_DIGITS - 1;
const ONE: u64 = 1.0_f64.to_bits();

impl Grid {
    fn new(lower: f64, upper: f64, knots_per_octave: u32) -> Self {
        let bits = knots_per_octave.ilog2();
        let cells = ((upper / lower).to_bits() - ONE).div_ceil(1 << (MANTISSA_BITS - bits));
        Self {
            lower,
            per_lower: 1.0 / lower,
            bits,
            n_cells: (cells as usize).max(1),
        }
    }

    /// `v` of a knot.
    fn ratio(&self, knot: usize) -> f64 {
        f64::from_bits(ONE + ((knot as u64) << (MANTISSA_BITS - self.bits)))
    }

    fn knot(&self, knot: usize) -> f64 {
        self.lower * self.ratio(knot)
    }

    fn width(&self, cell: usize) -> f64 {
        self.lower * (self.ratio(cell + 1) - self.ratio(cell))
    }

    #[inline(always)]
    fn locate(&self, u: f64) -> Location {
        let v = u * self.per_lower;
        if v < 1.0 {
            return Location::Below;
        }
        let bits = v.to_bits();
        let cell = ((bits - ONE) >> (MANTISSA_BITS - self.bits)) as usize;
        if cell >= self.n_cells {
            return Location::Above;
        }
        // The mantissa's remaining bits, moved to its top, are the fraction of the cell; the cell's width is a power of
        // two in v, so its reciprocal is an exponent alone.
        let fraction = (bits << self.bits) & ((1 << MANTISSA_BITS) - 1);
        let exponent = bits >> MANTISSA_BITS;
        let per_width = f64::from_bits((2046 - exponent + u64::from(self.bits)) << MANTISSA_BITS);
        Location::Cell {
            cell,
            s: f64::from_bits(ONE | fraction) - 1.0,
            per_width: per_width * self.per_lower,
        }
    }

    /// Coefficients of a cell's cubic from the values and slopes at its knots.
    fn cubic(&self, cell: usize, knots: &[Knot]) -> [f64; 4] {
        let (left, right, width) = (knots[cell], knots[cell + 1], self.width(cell));
        let (m0, m1, rise) = (left.slope * width, right.slope * width, right.value - left.value);
        [left.value, m0, 3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise]
    }
}

#[derive(Debug, Clone, Copy)]
struct Knot {
    value: f64,
    slope: f64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Worst {
    error: f64,
    interference: f64,
}

/// Curves at the knots of a grid: `t_n`, `k_x`, `k_y`.
struct Curves {
    grid: Grid,
    knots: [Vec<Knot>; 3],
}

impl Curves {
    fn tabulate(source: &impl ContactCurves, grid: Grid) -> Result<Self, Error> {
        let mut knots: [Vec<Knot>; 3] = core::array::from_fn(|_| Vec::with_capacity(grid.n_cells + 1));
        for i in 0..=grid.n_cells {
            let u = grid.knot(i);
            for ((knots, sample), name) in knots.iter_mut().zip(sample(source, u)).zip(CURVES) {
                let requirement = AT_KNOTS.text();
                let ok = sample.value.is_finite() && sample.value >= 0.0 && !sample.slope.is_nan();
                require(ok, name, sample.value, "(Pa or Pa/m)", Place::Entry(i), requirement)?;
                let before = knots.last().map_or(0.0, |knot| knot.value);
                // A flat curve may fall by its rounding.
                if sample.value < before * (1.0 - 1e-12) {
                    let log_slope = (sample.value - before) / grid.width(i - 1) * u / before;
                    return Err(Error::NotMonotone {
                        curve: name,
                        interference: u,
                        log_slope,
                    });
                }
                knots.push(Knot {
                    value: sample.value.max(before),
                    ..sample
                });
            }
        }
        for knots in &mut knots {
            limit_slopes(&grid, knots);
        }
        Ok(Self { grid, knots })
    }

    /// Largest relative error per curve between the knots.
    fn measure(&self, source: &impl ContactCurves) -> [Worst; 3] {
        let mut worst = [Worst::default(); 3];
        for cell in 0..self.grid.n_cells {
            let cubics = self.knots.each_ref().map(|knots| self.grid.cubic(cell, knots));
            for check in 0..N_CHECKS {
                let s = (f64::from(check) + 0.5) / f64::from(N_CHECKS);
                let u = self.grid.knot(cell) + s * self.grid.width(cell);
                let exact = sample(source, u);
                for i in 0..3 {
                    let scale = self.knots[i][cell + 1].value;
                    let deviation = (evaluate(&cubics[i], s, 1.0).value - exact[i].value).abs();
                    // A source that is not a number here must not pass.
                    if deviation.is_nan() || deviation > worst[i].error * scale {
                        let error = if deviation.is_nan() {
                            f64::INFINITY
                        } else {
                            deviation / scale
                        };
                        worst[i] = Worst { error, interference: u };
                    }
                }
            }
        }
        worst
    }

    fn ends(&self, knots: &[Knot]) -> [End; 2] {
        [0, self.grid.n_cells].map(|i| End::new(self.grid.knot(i), knots[i].value, knots[i].slope))
    }
}

fn sample(source: &impl ContactCurves, u: f64) -> [Knot; 3] {
    let (value, slope) = source.normal(u);
    let [x, y] = source.tangential(u).map(|k| Knot {
        value: k.value,
        slope: k.slope,
    });
    [Knot { value, slope }, x, y]
}

fn limit_slopes(grid: &Grid, knots: &mut [Knot]) {
    let secant = |knots: &[Knot], cell: usize| (knots[cell + 1].value - knots[cell].value) / grid.width(cell);
    for i in 0..knots.len() {
        let left = if i > 0 { secant(knots, i - 1) } else { f64::INFINITY };
        let right = if i + 1 < knots.len() {
            secant(knots, i)
        } else {
            f64::INFINITY
        };
        knots[i].slope = knots[i].slope.clamp(0.0, 3.0 * left.min(right));
    }
    // The curve is zero below.
    if knots[0].value == 0.0 {
        knots[0].slope = 0.0;
    }
}
