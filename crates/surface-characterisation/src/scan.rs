//! One face over all elements: forms, peaks, radii and counts.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::areal::{ArealParameters, ArealPatch};
use crate::detrend::{LinearFit, Plane, trend};
use crate::error::SurfaceError;
use crate::face::{FaceAsperities, face_count};
use crate::gap::{Bilinear, pair_gap};
use crate::options::Options;
use crate::partition::{ElementOutlines, Partition};
use crate::peaks::{LinePeak, line_peaks, summits};
use crate::registration::Registration;
use crate::resolution::{PeakSums, Resolution};
use crate::topography::HeightMap;

/// Fewest points of one face in an element from which a form and its roughness are told apart.
const LEAST_POINTS: usize = 16;
/// Points beyond an element that its peaks may lean on, so that those at its edge are resolved too.
const MARGIN: usize = 8;

/// What happened to one whole face.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FaceSummary {
    /// The plane that was taken off; of the bottom face, less the tilt of the registration.
    pub trend: Plane,
    /// Highest level of the face above that plane (m): zero of its gap.
    pub reference: f64,
    /// Points with data that belong to an element.
    pub points: usize,
    /// Points without data inside elements.
    pub missing: usize,
    /// Points with data in no element (bolt holes, beyond the outline), dropped.
    pub outside: usize,
    /// Points dropped as outliers, anywhere on the map.
    pub outliers: usize,
    /// Areal parameters of all elements together, above the plane: form and waviness are in them.
    pub areal: ArealParameters,
}

/// All elements of one face, `name`, which `registration` moves.
pub(crate) fn scan_face(
    name: &'static str,
    map: &HeightMap,
    elements: &ElementOutlines,
    registration: Registration,
    options: &Options,
) -> Result<(Vec<FaceAsperities>, FaceSummary), SurfaceError> {
    let (mut map, outliers) = options.noise.apply(map)?;
    if registration.shift != [0.0; 2] {
        map = Cow::Owned(map.into_owned().shifted(registration.shift)?);
    }
    let map = map.as_ref();
    let trend = registration.tilted(trend(map, elements, options.detrend)?, elements)?;
    let partition = Partition::new(map, elements);
    let scans = (0..elements.len())
        .into_par_iter()
        .map(|e| {
            let scan = ElementScan {
                map,
                partition: &partition,
                trend: &trend,
                elements,
                element: e,
            };
            scan.asperities(name, options)
        })
        .collect::<Vec<_>>();
    // In order, so that of several errors the first element's is reported on any number of threads.
    let found = scans.into_iter().collect::<Result<Vec<_>, _>>()?;
    let summary = FaceSummary {
        areal: whole_face(map, &partition, &trend, options.pruning)?,
        trend,
        reference: found.iter().map(|f| f.summit_level).fold(f64::NEG_INFINITY, f64::max),
        points: partition.points.iter().sum(),
        missing: partition.missing.iter().sum(),
        outside: partition.outside,
        outliers,
    };
    Ok((found, summary))
}

/// The gap of every element, in order, between two faces as [`scan_face`] finds them.
pub(crate) fn gaps(
    top: &(Vec<FaceAsperities>, FaceSummary),
    bottom: &(Vec<FaceAsperities>, FaceSummary),
) -> Vec<Bilinear> {
    let of_element = |(t, b): (&FaceAsperities, &FaceAsperities)| {
        pair_gap(
            [&t.plane, &b.plane],
            [t.tallest, b.tallest],
            [top.1.reference, bottom.1.reference],
        )
    };
    top.0.iter().zip(&bottom.0).map(of_element).collect()
}

/// Areal parameters of all points in elements above the plane of the face.
fn whole_face(
    map: &HeightMap,
    partition: &Partition,
    trend: &Plane,
    pruning: f64,
) -> Result<ArealParameters, SurfaceError> {
    let nx = map.nx();
    let mut heights = vec![f64::NAN; nx * map.ny()];
    heights.par_chunks_mut(nx).enumerate().for_each(|(j, row)| {
        for (i, z) in row.iter_mut().enumerate() {
            if partition.element(i, j).is_some() {
                *z = map.value(j * nx + i) - trend.at(map.position(i, j));
            }
        }
    });
    let patch = ArealPatch {
        heights: &heights,
        nx,
        step: map.step(),
        height_step: map.height_step().unwrap_or(0.0),
    };
    patch
        .parameters(pruning, |_| true)?
        .ok_or(SurfaceError::UndeterminedPlane {
            place: "face within the elements",
            points: 0,
        })
}

/// One element of one face.
struct ElementScan<'a> {
    map: &'a HeightMap,
    partition: &'a Partition,
    trend: &'a Plane,
    elements: &'a ElementOutlines,
    element: usize,
}

/// Residual heights over an element and its margin; NaN where there is no data or no element.
struct Patch {
    heights: Vec<f64>,
    n: [usize; 2],
    first: [usize; 2],
}

/// The form of an element's points.
struct Form {
    plane: Bilinear,
    /// Highest point above it (m).
    tallest_point: f64,
    /// Highest de-trended point (m).
    summit_level: f64,
}

impl ElementScan<'_> {
    /// Positions and de-trended heights of the element's points within a window of first and end indices along x and y.
    fn owned(&self, window: [(usize, usize); 2]) -> impl Iterator<Item = ([f64; 2], f64)> {
        let map = self.map;
        (window[1].0..window[1].1)
            .flat_map(move |j| (window[0].0..window[0].1).map(move |i| (i, j)))
            .filter(move |&(i, j)| self.partition.owns(self.element, i, j))
            .filter_map(move |(i, j)| {
                let p = map.position(i, j);
                map.height(i, j).map(|z| (p, z - self.trend.at(p)))
            })
    }

    /// The bilinear form of the element's points; `None` where they do not determine one.
    fn form(&self, window: [(usize, usize); 2]) -> Option<Form> {
        let mut plane = Bilinear::zero(self.elements, self.element);
        let mut fit = LinearFit::<4>::default();
        for (p, z) in self.owned(window) {
            fit.add(plane.columns(p), z);
        }
        plane.coefficients = fit.solve()?;
        let mut form = Form {
            plane,
            tallest_point: f64::NEG_INFINITY,
            summit_level: f64::NEG_INFINITY,
        };
        for (p, z) in self.owned(window) {
            form.tallest_point = form.tallest_point.max(z - form.plane.at(p));
            form.summit_level = form.summit_level.max(z);
        }
        Some(form)
    }

    fn asperities(&self, face: &'static str, options: &Options) -> Result<FaceAsperities, SurfaceError> {
        let (map, element) = (self.map, self.element);
        let (points, missing) = (self.partition.points[element], self.partition.missing[element]);
        let too_few = SurfaceError::TooFewPoints {
            element,
            face,
            points,
            missing,
            needed: LEAST_POINTS,
        };
        if points < LEAST_POINTS {
            return Err(too_few);
        }
        let (low, high) = self.elements.element_bounds(element);
        // One point wider than the bounding box: owned points may lie on the outline within rounding.
        let window = [0, 1].map(|k| {
            let (first, end) = map.indices_within(k, low[k], high[k]);
            (first.saturating_sub(1), (end + 1).min([map.nx(), map.ny()][k]))
        });
        let Form {
            plane,
            tallest_point,
            mut summit_level,
        } = self.form(window).ok_or_else(|| too_few.clone())?;

        let patch = self.patch(&plane, window);
        let height_step = map.height_step().unwrap_or(0.0);
        let level = 0.5 * height_step;
        let areal = ArealPatch {
            heights: &patch.heights,
            nx: patch.n[0],
            step: map.step(),
            height_step,
        };
        let within = |k: usize| {
            let (i, j) = (k % patch.n[0], k / patch.n[0]);
            self.partition.owns(element, patch.first[0] + i, patch.first[1] + j)
        };
        let areal = areal.parameters(options.pruning, within)?.ok_or(too_few)?;
        let mut curvatures = [vec![], vec![]];
        let mut heights = Vec::new();
        let mut sums = [PeakSums::default(); 2];
        for axis in 0..2 {
            for (vertex, peak) in self.line_peaks_along(axis, &patch, level, &mut sums[axis]) {
                curvatures[axis].push(peak.curvature);
                heights.push(peak.height);
                summit_level = summit_level.max(peak.height + plane.at(vertex));
            }
        }
        let summits = summits(&patch.heights, patch.n[0], level)
            .into_iter()
            .filter(|s| self.partition.owns(element, patch.first[0] + s.i, patch.first[1] + s.j))
            .count();
        let tallest = heights.iter().copied().reduce(f64::max).unwrap_or(tallest_point);
        if let Some(datum) = heights.iter().copied().reduce(f64::min) {
            for z in &mut heights {
                *z -= datum;
            }
        }
        let mut face = FaceAsperities {
            points,
            missing,
            plane,
            areal,
            peaks: [curvatures[0].len(), curvatures[1].len()],
            summits,
            radius: [options.radius.of(&curvatures[0]), options.radius.of(&curvatures[1])],
            resolution: Resolution::new(map, points, sums),
            heights,
            tallest,
            summit_level,
            asperity_count: None,
        };
        let area = self.elements.area(element);
        face.asperity_count = face_count(
            &face,
            area,
            options.count,
            options.packing_height,
            options.packing_efficiency,
        )?;
        Ok(face)
    }

    fn patch(&self, plane: &Bilinear, window: [(usize, usize); 2]) -> Patch {
        let limit = [self.map.nx(), self.map.ny()];
        let first = [0, 1].map(|k| window[k].0.saturating_sub(MARGIN));
        let n = [0, 1].map(|k| (window[k].1 + MARGIN).min(limit[k]) - first[k]);
        let mut heights = Vec::with_capacity(n[0] * n[1]);
        for j in first[1]..first[1] + n[1] {
            for i in first[0]..first[0] + n[0] {
                let p = self.map.position(i, j);
                let z = self.map.height(i, j).filter(|_| self.partition.element(i, j).is_some());
                heights.push(z.map_or(f64::NAN, |z| z - self.trend.at(p) - plane.at(p)));
            }
        }
        Patch { heights, n, first }
    }

    /// Peaks along x lines (`axis` 0) or y lines (1) whose middle the element owns, with the position of the vertex.
    fn line_peaks_along(
        &self,
        axis: usize,
        patch: &Patch,
        level: f64,
        sums: &mut PeakSums,
    ) -> Vec<([f64; 2], LinePeak)> {
        let (along, across) = (patch.n[axis], patch.n[1 - axis]);
        let (stride, line_stride) = if axis == 0 { (1, patch.n[0]) } else { (patch.n[0], 1) };
        let step = self.map.step()[axis];
        let mut profile = vec![0.0; along];
        let mut found = Vec::new();
        for line in 0..across {
            for (k, z) in profile.iter_mut().enumerate() {
                *z = patch.heights[line * line_stride + k * stride];
            }
            for peak in line_peaks(&profile, step, level) {
                let (i, j) = if axis == 0 {
                    (peak.index, line)
                } else {
                    (line, peak.index)
                };
                let (i, j) = (patch.first[0] + i, patch.first[1] + j);
                if self.partition.owns(self.element, i, j) {
                    let mut vertex = self.map.position(i, j);
                    vertex[axis] += peak.position - peak.index as f64 * step;
                    sums.add(&peak, &profile, step);
                    found.push((vertex, peak));
                }
            }
        }
        found
    }
}
