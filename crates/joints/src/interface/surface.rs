//! From a scene's scans to characterised faces, with an account of the files.

use crate::Error;
use contact_laws::ElasticPair;
use dense_algebra::Limits;
use scenes::{Length, Place, Readings, ScanFile, Scans, Scene, Surface, SyntheticScan};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use surface_characterisation::readers::{self, Declaration, Format};
use surface_characterisation::{
    Alignment, Bootstrap, Characterisation, ElementOutlines, ElementSurface, FaceSummary, GapChange, HeightMap,
    LinePeak, Options, Registration, Summary, SurfaceError, SyntheticFace, Waviness, align, characterise_until,
    line_peaks, registration_study,
};
use zte_assembly::{Element, InterfaceMesh};

/// Reference interference of the fits (m).
pub(crate) const U_REF: f64 = 1e-6;

/// With more points than this per different height, a file that states no height step was most likely quantised.
const POINTS_PER_HEIGHT: usize = 100;

/// What came of one file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FileReport {
    /// The file.
    pub path: PathBuf,
    /// Its format.
    pub format: Format,
    /// Unit of positions, and who stated it.
    pub lateral_unit: Declaration,
    /// Unit of heights, and who stated it.
    pub height_unit: Declaration,
    /// Points along x and y.
    pub points: [usize; 2],
    /// Points without data.
    pub missing: usize,
    /// Lateral steps (m).
    pub step: [f64; 2],
    /// Position of the point of lowest x and y in the plane of the interface (m).
    pub origin: [f64; 2],
    /// Height step in use (m): the scene's, or what the file states.
    pub height_step: Option<f64>,
    /// Smallest difference of heights found (m).
    pub smallest_step: Option<f64>,
    /// Different heights found.
    pub distinct_heights: usize,
    /// How the face was moved onto the interface, where that was asked for.
    pub alignment: Option<Alignment>,
    /// What was ignored or settled by convention.
    pub notes: Vec<String>,
}

/// Two faces in the frame of the interface, and what was found on them.
#[derive(Clone, Debug)]
pub struct ScannedSurface {
    /// Top and bottom face, before noise and registration are dealt with.
    pub faces: [HeightMap; 2],
    /// The elements.
    pub outlines: ElementOutlines,
    /// About the files; empty for synthetic faces.
    pub files: Vec<FileReport>,
    /// What was found; it repeats the settings.
    pub found: Characterisation,
}

impl ScannedSurface {
    /// Characterises the scans of a scene over the elements of `mesh`.
    ///
    /// # Errors
    /// [`Error::NoSamples`] for surfaces that are not scanned; of the readers, the alignment, the characterisation.
    pub fn try_new(scene: &Scene, mesh: &InterfaceMesh) -> Result<Self, Error> {
        Self::within(Limits::default(), scene, mesh)
    }

    /// The same within limits of time.
    ///
    /// # Errors
    /// As [`ScannedSurface::try_new`]; an interruption.
    pub fn within(limits: Limits<'_>, scene: &Scene, mesh: &InterfaceMesh) -> Result<Self, Error> {
        let outlines =
            ElementOutlines::try_new(mesh.nodes.clone(), mesh.elements.iter().map(Element::outline).collect())?;
        let mut options = Options::new(material(scene)?);
        options.tangential = scene.interfaces.law.tangential;
        options.u_ref = U_REF;
        let (faces, files) = match &scene.interfaces.surface {
            Surface::SyntheticScan(scan) => {
                options.registration = scan.registration.into();
                options.bootstrap = Bootstrap {
                    realisations: scan.bootstrap,
                    seed: scan.seed,
                    ..Bootstrap::default()
                };
                let is_void = |position| match scene.structure.benchmark() {
                    Some(benchmark) => benchmark.is_void(position),
                    None => false,
                };
                let face = |side| synthetic(scan, mesh, side, is_void);
                ([face(0)?, face(1)?], Vec::new())
            }
            Surface::Scans(scans) => {
                set(&mut options, scans);
                let (top, bottom) = rayon::join(
                    || face(&scans.top, scans.align.map(Length::si), &outlines),
                    || face(&scans.bottom, scans.align.map(Length::si), &outlines),
                );
                let ((top, about_top), (bottom, about_bottom)) = (top?, bottom?);
                ([top, bottom], vec![about_top, about_bottom])
            }
            Surface::Measured | Surface::Benchmark(_) | Surface::Finish(_) | Surface::Parameters(_) => {
                return Err(Error::NoSamples);
            }
        };
        let found = characterise_until(&|| limits.stops(), &faces[0], &faces[1], &outlines, &options)?;
        Ok(Self {
            faces,
            outlines,
            files,
            found,
        })
    }
}

/// Version of the layout of [`SurfaceReport`]; grows with every change that is not a mere addition.
pub const SCHEMA_VERSION: u32 = 1;

/// The machine-readable account of a characterisation, all in SI; elements and their nodes count from 0.
#[derive(Clone, Debug, Serialize)]
pub struct SurfaceReport<'a> {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// The files of the top and the bottom face; empty for synthetic faces.
    pub files: &'a [FileReport],
    /// All settings and readings.
    pub options: &'a Options,
    /// Counts and medians over the elements.
    pub summary: Summary,
    /// The whole top and bottom face.
    pub faces: &'a [FaceSummary; 2],
    /// What other registrations do to the gap; left out unless asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration_study: Option<&'a [GapChange]>,
    /// Every element.
    pub elements: &'a [ElementSurface],
}

/// A line along x through the middle of an element on one face.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Positions along x (m).
    pub x: Vec<f64>,
    /// Their y (m).
    pub y: f64,
    /// Heights as they are characterised (m), NaN where there is no data.
    pub height: Vec<f64>,
    /// Plane of the face and form of the element (m).
    pub form: Vec<f64>,
    /// Peaks of `height - form`; their positions count from the first point (m).
    pub peaks: Vec<LinePeak>,
}

impl ScannedSurface {
    /// The account of it all.
    pub fn report<'a>(&'a self, study: Option<&'a [GapChange]>) -> SurfaceReport<'a> {
        SurfaceReport {
            schema_version: SCHEMA_VERSION,
            files: &self.files,
            options: &self.found.options,
            summary: self.found.summary(),
            faces: &self.found.faces,
            registration_study: study,
            elements: &self.found.elements,
        }
    }

    /// What the bottom face's motion against the top one does to the gap: from the registration in use by one and by ten
    /// lateral steps to either side along x and y, and by slopes of 1e-5 and 1e-4 either way.
    ///
    /// # Errors
    /// As [`surface_characterisation::registration_study`]: shifts that leave elements without data are refused.
    pub fn registration_study(&self) -> Result<Vec<GapChange>, Error> {
        let [top, bottom] = &self.faces;
        let base = self.found.options.registration;
        let mut all = Vec::new();
        for axis in 0..2 {
            for by in [-10.0, -1.0, 1.0, 10.0] {
                let mut moved = base;
                moved.shift[axis] += by * bottom.step()[axis];
                all.push(moved);
            }
        }
        for axis in 0..2 {
            for by in [-1e-4, -1e-5, 1e-5, 1e-4] {
                let mut tilted: Registration = base;
                tilted.tilt[axis] += by;
                all.push(tilted);
            }
        }
        Ok(registration_study(
            top,
            bottom,
            &self.outlines,
            &self.found.options,
            &all,
        )?)
    }

    /// The profile of `element` on the top (0) or bottom (1) face, from which peaks along x are taken on its line.
    ///
    /// # Errors
    /// Those of the noise handling and the registration, which were good once.
    pub fn profile(&self, element: usize, side: usize) -> Result<Profile, Error> {
        let options = &self.found.options;
        let (map, _) = options.noise.apply(&self.faces[side])?;
        let mut map = map.into_owned();
        if side == 1 {
            map = map.shifted(options.registration.shift)?;
        }
        let (trend, face) = (&self.found.faces[side].trend, &self.found.elements[element].faces[side]);
        let (centre, half) = (face.plane.centre, face.plane.half_width);
        let nearest = |axis: usize, x: f64, n: usize| {
            let index = ((x - map.origin()[axis]) / map.step()[axis]).round();
            index.clamp(0.0, (n - 1) as f64) as usize
        };
        let j = nearest(1, centre[1], map.ny());
        let columns = nearest(0, centre[0] - half[0], map.nx())..nearest(0, centre[0] + half[0], map.nx()) + 1;
        let positions: Vec<[f64; 2]> = columns.clone().map(|i| map.position(i, j)).collect();
        let height: Vec<f64> = columns.map(|i| map.height(i, j).unwrap_or(f64::NAN)).collect();
        let form: Vec<f64> = positions.iter().map(|&p| trend.at(p) + face.plane.at(p)).collect();
        let residual: Vec<f64> = height.iter().zip(&form).map(|(z, form)| z - form).collect();
        let level = 0.5 * map.height_step().unwrap_or(0.0);
        Ok(Profile {
            x: positions.iter().map(|p| p[0]).collect(),
            y: map.position(0, j)[1],
            peaks: line_peaks(&residual, map.step()[0], level),
            height,
            form,
        })
    }
}

/// Two faces of the scene's material.
///
/// # Errors
/// [`scenes::Error::NoMaterial`].
pub(crate) fn material(scene: &Scene) -> Result<ElasticPair, Error> {
    let material = scene.model.material()?;
    Ok(ElasticPair {
        youngs_modulus: material.youngs_modulus.si(),
        poisson_ratio: material.poisson_ratio,
    })
}

fn set(options: &mut Options, scans: &Scans) {
    options.noise = scans.noise.into();
    options.registration = scans.registration.into();
    options.detrend = scans.detrend;
    set_readings(options, &scans.readings);
    options.bootstrap = Bootstrap {
        realisations: scans.bootstrap,
        seed: scans.seed,
        tallest: scans.tallest,
    };
}

/// Takes over the readings of a scene.
pub(super) fn set_readings(options: &mut Options, readings: &Readings) {
    options.radius = readings.radius;
    options.pair_radius = readings.pair_radius;
    options.packing_height = readings.packing_height;
    options.count = readings.count;
    options.heights = readings.heights;
}

/// Lowest and highest coordinate of the interface along an axis (m).
pub(super) fn bounds(mesh: &InterfaceMesh, axis: usize) -> (f64, f64) {
    mesh.nodes
        .iter()
        .map(|x| x[axis])
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
}

/// A scanned face in the frame of the interface.
fn face(file: &ScanFile, reach: Option<f64>, outlines: &ElementOutlines) -> Result<(HeightMap, FileReport), Error> {
    let scan = readers::read(
        &file.path,
        &readers::Options {
            format: file.format,
            lateral_unit: file.lateral_unit,
            height_unit: file.height_unit,
            lateral_step: file.lateral_step,
            first_row: file.first_row,
            layer: file.layer,
            array: file.array.clone(),
            header_lines: file.header_lines,
            accept_implausible: file.accept_implausible,
        },
    )?;
    let failed = |source| Error::ScannedFace {
        path: file.path.clone(),
        source,
    };
    let mut notes = scan.notes;
    let (mut map, alignment) = in_frame(scan.map, outlines, file.mirrored, file.place, reach).map_err(failed)?;
    let height_step = file.height_step.map(Length::si).or(scan.stated_step);
    match height_step {
        Some(step) => map = map.with_height_step(step).map_err(failed)?,
        None if scan.distinct_heights.saturating_mul(POINTS_PER_HEIGHT) < map.nx() * map.ny() => notes.push(format!(
            "{} different heights, {:.3e} m apart at least: state the height step of the instrument (height_step), or \
             steps will count as peaks",
            scan.distinct_heights,
            scan.smallest_step.unwrap_or(0.0)
        )),
        None => {}
    }
    let report = FileReport {
        path: file.path.clone(),
        format: scan.format,
        lateral_unit: scan.lateral_unit,
        height_unit: scan.height_unit,
        points: [map.nx(), map.ny()],
        missing: map.missing(),
        step: map.step(),
        origin: map.origin(),
        height_step,
        smallest_step: scan.smallest_step,
        distinct_heights: scan.distinct_heights,
        alignment,
        notes,
    };
    Ok((map, report))
}

/// A scan in the frame of the interface: turned over about the middle of the elements if it was `mirrored`, brought to its
/// `place`, and moved by at most `reach` (m) along x and y to where the edges and holes of its mask fit the elements.
///
/// # Errors
/// Positions that are not finite; those of [`align`].
pub fn in_frame(
    mut map: HeightMap,
    outlines: &ElementOutlines,
    mirrored: bool,
    place: Place,
    reach: Option<f64>,
) -> Result<(HeightMap, Option<Alignment>), SurfaceError> {
    let (low, high) = outlines.bounds();
    let middle = [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]));
    if mirrored {
        map = map.mirrored_x(middle[0]);
    }
    let target = match place {
        Place::AsStated => None,
        Place::Centred => {
            let n = [map.nx(), map.ny()];
            Some([0, 1].map(|k| middle[k] - 0.5 * (n[k] - 1) as f64 * map.step()[k]))
        }
        Place::Origin(origin) => Some(origin.map(Length::si)),
    };
    if let Some(target) = target {
        let origin = map.origin();
        map = map.shifted([0, 1].map(|k| target[k] - origin[k]))?;
    }
    let Some(reach) = reach else {
        return Ok((map, None));
    };
    let found = align(&map, outlines, reach)?;
    Ok((map.shifted(found.shift)?, Some(found)))
}

/// The faces of a synthetic scan as they are measured, over the bounding box of the interface, without data where the
/// position (m) `is_void`; the bottom one has its own seed and waviness phase.
///
/// # Errors
/// Settings outside their range.
pub fn synthetic(
    scan: &SyntheticScan,
    mesh: &InterfaceMesh,
    side: u64,
    is_void: impl Fn([f64; 2]) -> bool + Sync,
) -> Result<HeightMap, Error> {
    let (x, y) = (bounds(mesh, 0), bounds(mesh, 1));
    let step = scan.step.map(Length::si);
    // A wrong step must end in an error of the generator, not in a request for all memory.
    let points = [(x, step[0]), (y, step[1])].map(|((low, high), step)| {
        let count = ((high - low) / step).floor() + 1.0;
        if count.is_finite() {
            count.clamp(0.0, 1e5) as usize
        } else {
            0
        }
    });
    let synthetic = SyntheticFace {
        points,
        step,
        origin: [x.0, y.0],
        rms: scan.rms.si(),
        correlation_length: scan.correlation_length.map(Length::si),
        waviness: vec![Waviness {
            amplitude: scan.waviness.si(),
            wavenumber: [1.0 / scan.wavelength.si(), 0.0],
            phase: 0.5 * std::f64::consts::PI * side as f64,
        }],
        tilt: scan.tilt,
        height_step: Some(scan.height_step.si()),
        seed: scan.seed.wrapping_add(side),
    };
    Ok(synthetic.generate(is_void)?)
}
