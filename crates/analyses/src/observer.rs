//! Watches hysteresis loops at the quadrature points.

use super::amplitude::{ElementMotions, Fields, JointLoop, LoopFields};
use super::connections::{Connection, Walked};
use super::element_loops::ElementLoops;
use super::walks::Walks;
use contact_laws::Regime;
use cqsma_solver::{BackbonePoint, LoopObserver};
use std::ops::{ControlFlow, Range};
use zte_assembly::flux::{self, LoopArea};
use zte_assembly::{Interface, Workspace};

/// Hears of a finished amplitude: its place in the backbone, the loop, and what it did at the interface.
pub(super) type Finish<'a> = dyn Fn(usize, &BackbonePoint, Option<&LoopFields>) -> ControlFlow<()> + Sync + 'a;

/// Range of the displacement at the response point along a loop.
pub(super) struct ResponseMotion<'a> {
    /// Recovers the displacement at the response point.
    response: &'a [f64],
    /// Smallest and largest so far (m).
    range: [f64; 2],
}

impl<'a> ResponseMotion<'a> {
    pub(super) fn new(response: &'a [f64]) -> Self {
        Self {
            response,
            range: [f64::INFINITY, f64::NEG_INFINITY],
        }
    }

    pub(super) fn half_range(&self) -> f64 {
        0.5 * (self.range[1] - self.range[0])
    }
}

impl LoopObserver<Workspace> for ResponseMotion<'_> {
    fn begin(&mut self) {
        *self = Self::new(self.response);
    }

    fn vertex(&mut self, _: f64, displacement: &[f64], _: &Workspace) {
        let motion: f64 = displacement.iter().zip(self.response).map(|(u, r)| u * r).sum();
        self.range = [self.range[0].min(motion), self.range[1].max(motion)];
    }
}

/// What is kept of an amplitude.
#[derive(Clone, Copy)]
pub(super) struct Stored<'a> {
    /// Elements whose loops are kept, ascending; none if no fields are.
    pub(super) elements: Option<&'a [usize]>,
    /// Whether the displacement at the positive peak is.
    pub(super) displacement: bool,
    /// Whether the largest motion and traction of every element are.
    pub(super) motions: bool,
}

/// Watches one loop at the quadrature points.
pub(super) struct Watcher<'a> {
    interface: &'a Interface,
    prestress: &'a Fields,
    motion: ResponseMotion<'a>,
    index: usize,
    store: bool,
    /// Elements whose loops are stored, ascending.
    recorded: &'a [usize],
    finish: &'a Finish<'a>,
    connections: &'a [Connection],
    walked: Walked<'a>,
    /// What the loop is walked with once more, and its jumps; none where errors are not estimated.
    walks: Option<&'a Walks<'a>>,
    path: Vec<Vec<f64>>,
    area: LoopArea,
    peak: f64,
    slip_fraction: f64,
    open_fraction: f64,
    /// Of each interface, where there are several.
    joints: Vec<JointLoop>,
    largest_sliding: f64,
    /// Largest tangential motion (m) and change of the tangential traction (Pa) of each point; none where they are not stored.
    largest: Option<[Vec<f64>; 2]>,
    /// The workspace at the positive peak, if it is to be stored.
    at_peak: Option<Workspace>,
    /// Whether the displacement at the positive peak is stored, and the displacement.
    stores_displacement: bool,
    displacement_at_peak: Option<Vec<f64>>,
    loops: Option<ElementLoops>,
    /// What came of the loop, when it is done and has converged.
    pub(super) fields: Option<LoopFields>,
}

impl<'a> Watcher<'a> {
    pub(super) fn new(
        interface: &'a Interface,
        prestress: &'a Fields,
        response: &'a [f64],
        index: usize,
        stored: Stored<'a>,
        connections: &'a [Connection],
        walks: Option<&'a Walks<'a>>,
        finish: &'a Finish<'a>,
    ) -> Self {
        Self {
            interface,
            prestress,
            motion: ResponseMotion::new(response),
            index,
            store: stored.elements.is_some(),
            recorded: stored.elements.unwrap_or(&[]),
            finish,
            connections,
            walked: Walked::new(connections),
            walks,
            path: Vec::new(),
            area: LoopArea::new(interface.operators().n_points()),
            peak: f64::NEG_INFINITY,
            slip_fraction: 0.0,
            open_fraction: 0.0,
            joints: Vec::new(),
            largest_sliding: 0.0,
            largest: stored.motions.then(Default::default),
            at_peak: None,
            stores_displacement: stored.displacement,
            displacement_at_peak: None,
            loops: None,
            fields: None,
        }
    }

    fn close(&mut self, point: &BackbonePoint) -> LoopFields {
        let flux = std::mem::replace(&mut self.area, LoopArea::new(0)).close();
        let weights = &self.interface.operators().weights;
        let dissipation = flux
            .iter()
            .map(|f| f.iter().zip(weights).map(|(f, w)| f * w).sum::<f64>())
            .sum();
        let mut joints = std::mem::take(&mut self.joints);
        for (joint, points) in joints.iter_mut().zip(self.interface.points_of_laws()) {
            let of_point = |p: usize| weights[p] * flux.iter().map(|f| f[p]).sum::<f64>();
            joint.dissipation = points.map(of_point).sum();
        }
        let connections = self.walked.close(weights, &flux);
        let elements = self.largest.as_ref().map(|[sliding, traction]| {
            let operators = self.interface.operators();
            ElementMotions {
                dissipation: operators.element_means(&flux::total(&flux)),
                sliding: operators.element_means(sliding),
                traction: operators.element_means(traction),
            }
        });
        LoopFields {
            slip_fraction: self.slip_fraction,
            open_fraction: self.open_fraction,
            joints,
            connections,
            dissipation,
            largest_sliding: self.largest_sliding,
            elements,
            response_motion: self.motion.half_range(),
            fields: self.at_peak.take().map(|peak| Fields {
                jump: peak.jump,
                traction: peak.traction,
                regime: peak.regime,
                flux,
            }),
            displacement: self.displacement_at_peak.take(),
            loops: self.loops.take(),
            errors: self
                .walks
                .map_or_else(Vec::new, |walks| walks.errors(&self.path, point)),
        }
    }
}

impl LoopObserver<Workspace> for Watcher<'_> {
    fn begin(&mut self) {
        self.area = LoopArea::new(self.interface.operators().n_points());
        (self.peak, self.largest_sliding) = (f64::NEG_INFINITY, 0.0);
        if let Some(largest) = &mut self.largest {
            *largest = std::array::from_fn(|_| vec![0.0; self.interface.operators().n_points()]);
        }
        self.motion.begin();
        self.path.clear();
        self.walked = Walked::new(self.connections);
        self.loops = (!self.recorded.is_empty()).then(|| ElementLoops::new(self.recorded));
    }

    fn done(&mut self, point: &BackbonePoint) -> ControlFlow<()> {
        self.fields = point.result.is_ok().then(|| self.close(point));
        (self.finish)(self.index, point, self.fields.as_ref())
    }

    fn vertex(&mut self, modal_force: f64, displacement: &[f64], workspace: &Workspace) {
        self.area.add(workspace);
        if let Some(loops) = &mut self.loops {
            loops.add(self.interface.operators(), modal_force, workspace);
        }
        self.motion.vertex(modal_force, displacement, workspace);
        let weights = &self.interface.operators().weights;
        self.walked.vertex(weights, workspace);
        if self.walks.is_some() {
            self.path.push(displacement[..self.interface.n_dofs()].to_vec());
        }
        for p in 0..workspace.regime.len() {
            let slide = |c: usize| workspace.jump[c][p] - self.prestress.jump[c][p];
            let sliding = slide(0).hypot(slide(1));
            self.largest_sliding = self.largest_sliding.max(sliding);
            if let Some([motions, tractions]) = &mut self.largest {
                let change = |c: usize| workspace.traction[c][p] - self.prestress.traction[c][p];
                motions[p] = motions[p].max(sliding);
                tractions[p] = tractions[p].max(change(0).hypot(change(1)));
            }
        }
        // The loop begins and ends at its positive peak; the end carries the regimes that led there.
        if modal_force >= self.peak {
            self.peak = modal_force;
            let operators = self.interface.operators();
            self.walked.peak(weights, workspace, self.prestress);
            let fraction = |regime: Regime, points: Range<usize>, area: f64| {
                let found = workspace.regime[points.clone()]
                    .iter()
                    .zip(&operators.weights[points])
                    .filter(|(r, _)| **r == regime);
                found.fold(0.0, |sum, (_, w)| sum + w) / area
            };
            let of = |(points, area): (Range<usize>, f64)| {
                let slip = fraction(Regime::Slip, points.clone(), area);
                (slip, fraction(Regime::Open, points, area))
            };
            (self.slip_fraction, self.open_fraction) = of((0..workspace.regime.len(), operators.area()));
            if self.interface.points_of_laws().nth(1).is_some() {
                let joints = self.interface.points_of_laws().map(|points| {
                    let area = operators.weights[points.clone()].iter().sum();
                    let (slip_fraction, open_fraction) = of((points, area));
                    JointLoop {
                        slip_fraction,
                        open_fraction,
                        dissipation: 0.0,
                    }
                });
                self.joints = joints.collect();
            }
            if self.store {
                self.at_peak = Some(workspace.clone());
            }
            if self.stores_displacement {
                self.displacement_at_peak = Some(displacement.to_vec());
            }
        }
    }
}
