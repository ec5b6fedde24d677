//! The functions that make laws.

use core::ffi::c_char;

use contact_laws::{
    Asperity, AsperityBins, AsperityFriction, AsperityPopulation, AsperitySumCurves, ElasticCurves, ElasticDryFriction,
    ElasticPair, FittedCurves, FittedPoints, GapDistribution, NormalFit, PointParameters, ResolvedLaw, RoughLaw,
    TableLaw, TableOptions, Tabulated, TangentialFit, Yield,
};

use crate::Law;
use crate::boundary::{Error, Message, array, guarded, rows};
use crate::choice::choice;

/// Rough contact by fitted curves (eqs. 28 and 29 of Balaji, Chen and Brake 2020) with friction. With
/// U = u_n / u_ref and natural logarithms, ln(t_n / 1 Pa) = a + b ln U + c exp(-((ln U + d)/e)^2 / 2) and
/// ln(k / 1 Pa/m) = a + b tanh(d (ln U - c)), k apart for x and y.
///
/// - n_points: number of points of the law, at least 1.
/// - normal: a, b, c, d, e of the normal traction, 5 x n_sets numbers, parameter by parameter.
/// - tangential_x, tangential_y: a, b, c, d of the tangential stiffnesses, 4 x n_sets numbers each, stored alike.
/// - u_ref: reference interference (m), n_sets numbers.
/// - ranges: fitted ranges (m), 6 x n_sets numbers: lower and upper end of the normal fit, of the fit along x, of the
///   fit along y. Beyond them the curves go on smoothly. NULL: the formulas hold everywhere.
/// - n_sets: 1 (the same for all points) or n_points (one set per point).
/// - ends: one of CL_ENDS_...; without effect where ranges is NULL.
/// - mu: friction coefficient, n_mu numbers; n_mu is 1 or n_points.
/// - history: one of CL_HISTORY_...
/// - message: NULL, or a buffer of message_capacity bytes that receives the reason of a refusal, ended by a zero.
///   One that overlaps an array is refused, and left alone. Parameter arrays may overlap one another.
///
/// Returns a law to be freed with cl_law_free, or NULL. The arrays are copied.
///
/// # Safety
/// Pointers that are not NULL have the lengths stated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_rough_law(
    n_points: usize,
    normal: *const f64,
    tangential_x: *const f64,
    tangential_y: *const f64,
    u_ref: *const f64,
    ranges: *const f64,
    n_sets: usize,
    ends: i32,
    mu: *const f64,
    n_mu: usize,
    history: i32,
    message: *mut c_char,
    message_capacity: usize,
) -> *mut Law {
    let message = Message::new(message, message_capacity);
    let make = || {
        require_points(n_points)?;
        require_sets("n_sets", n_sets, n_points)?;
        // SAFETY: the lengths are the documented ones, for which the caller vouches.
        let ([a, b, c, d, e], x, y, u_ref) = unsafe {
            (
                rows(message, "normal", normal, n_sets)?,
                rows::<4>(message, "tangential_x", tangential_x, n_sets)?,
                rows::<4>(message, "tangential_y", tangential_y, n_sets)?,
                array(message, "u_ref", u_ref, n_sets)?,
            )
        };
        let ranges = match ranges.is_null() {
            true => None,
            // SAFETY: as above.
            false => Some(unsafe { rows::<6>(message, "ranges", ranges, n_sets) }?),
        };
        let ends = choice("ends", ends)?;
        let curves = per_set(n_sets, |set| {
            let range = |fit: usize| ranges.map(|r| [r[2 * fit][set], r[2 * fit + 1][set]]);
            let tangential = |[a, b, c, d]: [&[f64]; 4], fit| TangentialFit {
                a: a[set],
                b: b[set],
                c: c[set],
                d: d[set],
                u_ref: u_ref[set],
                k_ref: 1.0,
                range: range(fit),
                ends,
            };
            let normal = NormalFit {
                a: a[set],
                b: b[set],
                c: c[set],
                d: d[set],
                e: e[set],
                u_ref: u_ref[set],
                t_ref: 1.0,
                range: range(0),
            };
            FittedCurves::try_new(normal, [tangential(x, 1), tangential(y, 2)])
        })?;
        let curves = PointParameters::one_or_each(curves, n_points);
        // SAFETY: as above.
        let mu = unsafe { friction(message, mu, n_mu, n_points) }?;
        Law::try_new(RoughLaw::try_new(
            FittedPoints::new(&curves),
            mu,
            choice("history", history)?,
        )?)
    };
    // SAFETY: the caller vouches for the message buffer.
    hand_over(unsafe { guarded(message, make) })
}

/// Elastic dry friction: constant stiffnesses with the Coulomb limit.
///
/// - n_points: number of points of the law, at least 1.
/// - k_n, k_x, k_y: normal and tangential stiffnesses per area (Pa/m), n_sets numbers each.
/// - n_sets: 1 (the same for all points) or n_points (one set per point).
/// - mu: friction coefficient, n_mu numbers; n_mu is 1 or n_points.
/// - history: one of CL_HISTORY_...; they differ only where an open point closes and in what the state remembers.
/// - message: NULL, or a buffer of message_capacity bytes that receives the reason of a refusal, ended by a zero.
///   One that overlaps an array is refused, and left alone. Parameter arrays may overlap one another.
///
/// Returns a law to be freed with cl_law_free, or NULL. The arrays are copied.
///
/// # Safety
/// Pointers that are not NULL have the lengths stated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_elastic_dry_friction_law(
    n_points: usize,
    k_n: *const f64,
    k_x: *const f64,
    k_y: *const f64,
    n_sets: usize,
    mu: *const f64,
    n_mu: usize,
    history: i32,
    message: *mut c_char,
    message_capacity: usize,
) -> *mut Law {
    let message = Message::new(message, message_capacity);
    let make = || {
        require_points(n_points)?;
        require_sets("n_sets", n_sets, n_points)?;
        // SAFETY: the lengths are the documented ones, for which the caller vouches.
        let (k_n, k_x, k_y, mu) = unsafe {
            (
                array(message, "k_n", k_n, n_sets)?,
                array(message, "k_x", k_x, n_sets)?,
                array(message, "k_y", k_y, n_sets)?,
                friction(message, mu, n_mu, n_points)?,
            )
        };
        let curves = per_set(n_sets, |set| ElasticCurves::try_new(k_n[set], [k_x[set], k_y[set]]))?;
        let curves = PointParameters::one_or_each(curves, n_points);
        Law::try_new(ElasticDryFriction::try_new(curves, mu, choice("history", history)?)?)
    };
    // SAFETY: the caller vouches for the message buffer.
    hand_over(unsafe { guarded(message, make) })
}

/// Rough contact as the sum over a population of asperities of two equal elastic bodies (Hertz, Mindlin), tabulated,
/// with friction. One population holds for all points.
///
/// - n_points: number of points of the law, at least 1.
/// - probabilities, gaps: quantiles of the gap (m) of the asperity pairs when the surfaces just touch, n_quantiles
///   numbers each; the probabilities rise from 0 to 1, the gaps do not fall and are not negative.
/// - density: asperity pairs per area (1/m^2).
/// - radius_x, radius_y: effective radii of the pairs (m).
/// - youngs_modulus (Pa), poisson_ratio: the material.
/// - reading: one of CL_READING_..., the tangential stiffness of an asperity.
/// - range_lower, range_upper: interferences (m) between which the curves are tabulated, with a relative error of at
///   most 1e-5 (normal) and 1e-4 (tangential). Beyond them they go on smoothly.
/// - mu: friction coefficient, n_mu numbers; n_mu is 1 or n_points.
/// - history: one of CL_HISTORY_...
/// - message: NULL, or a buffer of message_capacity bytes that receives the reason of a refusal, ended by a zero.
///   One that overlaps an array is refused, and left alone. Parameter arrays may overlap one another.
///
/// Returns a law to be freed with cl_law_free, or NULL. The arrays are copied.
///
/// # Safety
/// Pointers that are not NULL have the lengths stated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_asperity_table_law(
    n_points: usize,
    probabilities: *const f64,
    gaps: *const f64,
    n_quantiles: usize,
    density: f64,
    radius_x: f64,
    radius_y: f64,
    youngs_modulus: f64,
    poisson_ratio: f64,
    reading: i32,
    range_lower: f64,
    range_upper: f64,
    mu: *const f64,
    n_mu: usize,
    history: i32,
    message: *mut c_char,
    message_capacity: usize,
) -> *mut Law {
    let message = Message::new(message, message_capacity);
    let make = || {
        require_points(n_points)?;
        // SAFETY: the lengths are the documented ones, for which the caller vouches.
        let (probabilities, gaps, mu) = unsafe {
            (
                array(message, "probabilities", probabilities, n_quantiles)?,
                array(message, "gaps", gaps, n_quantiles)?,
                friction(message, mu, n_mu, n_points)?,
            )
        };
        let reading = choice("reading", reading)?;
        let gaps = GapDistribution::try_from_quantiles(probabilities, gaps)?;
        let population = AsperityPopulation::try_new(gaps, density, [radius_x, radius_y])?;
        let material = ElasticPair::new(youngs_modulus, poisson_ratio);
        let curves = AsperitySumCurves::try_new(population, material, reading)?;
        let table = Tabulated::try_new(curves, [range_lower, range_upper], TableOptions::default())?;
        let curves = PointParameters::uniform(table, n_points);
        Law::try_new(TableLaw::try_new(curves, mu, choice("history", history)?)?)
    };
    // SAFETY: the caller vouches for the message buffer.
    hand_over(unsafe { guarded(message, make) })
}

/// Friction resolved over asperities of two equal bodies: a population in bins of one initial gap each, and every bin
/// has a history of its own. Normal force by Hertz, or with yield and unloading.
///
/// - n_points: number of points of the law, at least 1.
/// - gaps, densities: initial gap (m, 0 is the first asperity to touch) and asperities per area (1/m^2) of the bins,
///   n_bins x n_sets numbers each, bin by bin. Sets with fewer bins end with bins of density 0.
/// - n_sets: 1 (the same for all points) or n_points (one set per point); any number, at least 1, with set_of_point.
/// - set_of_point: NULL, or the set of every point, n_points numbers, counted from 0.
/// - radius: effective radius of an asperity (m).
/// - youngs_modulus (Pa), poisson_ratio: the material.
/// - yield_strength (Pa): 0 for elastic asperities.
/// - tangent_modulus (Pa): of the hardening material, 0 or more; without effect where yield_strength is 0.
/// - yield_curves: one of CL_YIELD_...; without effect where yield_strength is 0.
/// - mu: friction coefficient, n_mu numbers; n_mu is 1 or n_points.
/// - history: one of CL_HISTORY_...; CL_HISTORY_POTENTIAL for elastic asperities only.
/// - cone: one of CL_CONE_...
/// - limit: CL_LIMIT_COULOMB, or for asperities that yield CL_LIMIT_CEB or CL_LIMIT_SHEAR_STRENGTH, with which mu is without
///   effect.
/// - n_annuli: 0: an asperity sticks or slips as a whole. 1 to 256: it slips from its rim inwards, in so many annuli.
/// - message: NULL, or a buffer of message_capacity bytes that receives the reason of a refusal, ended by a zero.
///   One that overlaps an array is refused, and left alone. Parameter arrays may overlap one another.
///
/// Returns a law to be freed with cl_law_free, or NULL. The arrays are copied.
///
/// # Safety
/// Pointers that are not NULL have the lengths stated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cl_resolved_law(
    n_points: usize,
    gaps: *const f64,
    densities: *const f64,
    n_bins: usize,
    n_sets: usize,
    set_of_point: *const u32,
    radius: f64,
    youngs_modulus: f64,
    poisson_ratio: f64,
    yield_strength: f64,
    tangent_modulus: f64,
    yield_curves: i32,
    mu: *const f64,
    n_mu: usize,
    history: i32,
    cone: i32,
    limit: i32,
    n_annuli: usize,
    message: *mut c_char,
    message_capacity: usize,
) -> *mut Law {
    let message = Message::new(message, message_capacity);
    let make = || {
        require_points(n_points)?;
        let index = match set_of_point.is_null() {
            true => None,
            // SAFETY: the length is the documented one, for which the caller vouches.
            false => Some(unsafe { array(message, "set_of_point", set_of_point, n_points) }?),
        };
        if index.is_none() {
            require_sets("n_sets", n_sets, n_points)?;
        }
        let total = |argument| n_bins.checked_mul(n_sets).ok_or(Error::TooLong { argument });
        // SAFETY: as above.
        let (gaps, densities, mu) = unsafe {
            (
                array(message, "gaps", gaps, total("gaps")?)?,
                array(message, "densities", densities, total("densities")?)?,
                friction(message, mu, n_mu, n_points)?,
            )
        };
        let curves = choice("yield_curves", yield_curves)?;
        let yielding = (yield_strength != 0.0).then_some(Yield {
            strength: yield_strength,
            tangent_modulus,
            curves,
        });
        let asperity = Asperity::try_new(ElasticPair::new(youngs_modulus, poisson_ratio), radius, yielding)?;
        let sets = per_set(n_sets, |set| {
            let of = |values: &[f64]| values.chunks_exact(n_sets).map(|bin| bin[set]).collect();
            AsperityBins::try_new(asperity, of(gaps), of(densities))
        })?;
        let bins = match index {
            None => PointParameters::one_or_each(sets, n_points),
            Some(index) => PointParameters::try_indexed(sets, index.to_vec())?,
        };
        let history = choice("history", history)?;
        let friction = match n_annuli {
            0 => AsperityFriction::StickSlip(history),
            n => AsperityFriction::Annuli(history, n),
        };
        let (cone, limit) = (choice("cone", cone)?, choice("limit", limit)?);
        Law::try_new(ResolvedLaw::try_new(bins, mu, friction, cone)?.with_limit(limit)?)
    };
    // SAFETY: the caller vouches for the message buffer.
    hand_over(unsafe { guarded(message, make) })
}

/// A law on its way to the caller, who frees it.
fn hand_over(law: Option<Law>) -> *mut Law {
    law.map_or(core::ptr::null_mut(), |law| Box::into_raw(Box::new(law)))
}

fn require_points(n_points: usize) -> Result<(), Error> {
    match u32::try_from(n_points) {
        Ok(0) => Err(Error::NoPoints),
        Ok(_) => Ok(()),
        Err(_) => Err(Error::TooManyPoints { n_points }),
    }
}

fn require_sets(argument: &'static str, n_sets: usize, n_points: usize) -> Result<(), Error> {
    if n_sets == 1 || n_sets == n_points {
        Ok(())
    } else {
        Err(Error::Sets {
            argument,
            n_sets,
            n_points,
        })
    }
}

/// The friction coefficients.
///
/// # Safety
/// As for [`array`].
unsafe fn friction(
    message: Message,
    mu: *const f64,
    n_mu: usize,
    n_points: usize,
) -> Result<PointParameters<f64>, Error> {
    require_sets("n_mu", n_mu, n_points)?;
    // SAFETY: the caller's promise.
    let mu = unsafe { array(message, "mu", mu, n_mu) }?;
    Ok(PointParameters::one_or_each(mu.to_vec(), n_points))
}

/// What is made of every set of parameters.
fn per_set<C>(n_sets: usize, make: impl Fn(usize) -> Result<C, contact_laws::Error>) -> Result<Vec<C>, Error> {
    let made = (0..n_sets).map(|set| make(set).map_err(|error| Error::Parameters { set, error }));
    made.collect()
}
