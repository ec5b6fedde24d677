//! Forces and tangent of an interface from nodal jumps, with one traction law per range of quadrature points.

use crate::Error;
use crate::operators::Operators;
use contact_laws::{
    Components, ComponentsMut, Regime, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut, TractionLaw,
};
use std::ops::Range;
use std::sync::Arc;

/// History of all points; opaque to solvers, which only swap and clone it.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// One block `[component][point]` per law, one after the other.
    values: Vec<f64>,
}

/// Quantities at the quadrature points, filled by [`Interface::evaluate`]; one value per point.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Jump x, y and interference n (gap subtracted) (m).
    pub jump: [Vec<f64>; 3],
    /// Traction x, y, n (Pa).
    pub traction: [Vec<f64>; 3],
    /// Contact regimes.
    pub regime: Vec<Regime>,
    /// Row-major 3 x 3 tangent entries, one vector per entry (Pa/m).
    tangent: [Vec<f64>; 9],
}

/// Sparse pattern of the tangent over `3 n_nodes` coordinates: compressed rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    /// Row starts.
    pub indptr: Vec<usize>,
    /// Columns, ascending in each row.
    pub indices: Vec<usize>,
}

/// An interface with its laws and its gap. Immutable: histories are passed in and out.
#[derive(Clone)]
pub struct Interface {
    operators: Arc<Operators>,
    laws: Vec<(Range<usize>, Arc<dyn TractionLaw>)>,
    gap: Vec<f64>,
    pattern: Arc<Pattern>,
    /// Neighbours of each node (itself included), ascending; block rows of the pattern.
    neighbours: Arc<Vec<Vec<usize>>>,
}

impl Interface {
    /// `laws` cover the points in order without holes; `gap` has one initial gap per point (m), at least zero.
    ///
    /// # Errors
    /// Laws that do not cover the points, a law of another length than its range, gaps that are negative or not finite.
    pub fn try_new(
        operators: Arc<Operators>,
        laws: Vec<(Range<usize>, Arc<dyn TractionLaw>)>,
        gap: Vec<f64>,
    ) -> Result<Self, Error> {
        let expected = operators.n_points();
        let mut found = 0;
        for (range, law) in &laws {
            if range.start != found || law.len() != range.len() {
                return Err(Error::Coverage {
                    what: "the traction laws",
                    found,
                    expected,
                });
            }
            found = range.end;
        }
        if found != expected {
            return Err(Error::Coverage {
                what: "the traction laws",
                found,
                expected,
            });
        }
        check_gap(&gap, expected)?;
        let n_nodes = operators.n_nodes();
        let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); n_nodes];
        for row in operators.interpolation.outer_iterator() {
            for &node in row.indices() {
                neighbours[node].extend_from_slice(row.indices());
            }
        }
        let mut pattern = Pattern {
            indptr: vec![0],
            indices: Vec::new(),
        };
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
            for _ in 0..3 {
                pattern
                    .indices
                    .extend(list.iter().flat_map(|node| (0..3).map(move |c| 3 * node + c)));
                pattern.indptr.push(pattern.indices.len());
            }
        }
        Ok(Self {
            operators,
            laws,
            gap,
            pattern: Arc::new(pattern),
            neighbours: Arc::new(neighbours),
        })
    }

    /// The same interface with another gap.
    ///
    /// # Errors
    /// As [`Interface::try_new`].
    pub fn with_gap(&self, gap: Vec<f64>) -> Result<Self, Error> {
        check_gap(&gap, self.operators.n_points())?;
        Ok(Self { gap, ..self.clone() })
    }

    /// Geometry and quadrature.
    pub fn operators(&self) -> &Operators {
        &self.operators
    }

    /// Initial gap of each point (m).
    pub fn gap(&self) -> &[f64] {
        &self.gap
    }

    /// Pattern of the tangent.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Coordinates it acts on: x, y, n of each node, node-major.
    pub fn n_dofs(&self) -> usize {
        3 * self.operators.n_nodes()
    }

    /// The law and the law's own number of a point.
    pub fn law(&self, point: usize) -> Option<(&dyn TractionLaw, usize)> {
        let (range, law) = self.laws.iter().find(|(range, _)| range.contains(&point))?;
        Some((law.as_ref(), point - range.start))
    }

    /// Memory for the quantities at the points.
    pub fn workspace(&self) -> Workspace {
        let n = self.operators.n_points();
        let zeros = || vec![0.0; n];
        Workspace {
            jump: std::array::from_fn(|_| zeros()),
            traction: std::array::from_fn(|_| zeros()),
            regime: vec![Regime::Open; n],
            tangent: std::array::from_fn(|_| zeros()),
        }
    }

    /// The history of bodies that rest at zero jump, separated by the gap.
    pub fn initial_state(&self) -> State {
        let size = self
            .laws
            .iter()
            .map(|(range, law)| range.len() * law.info().n_state())
            .sum();
        let untouched = State {
            values: vec![0.0; size],
        };
        let mut state = untouched.clone();
        let (mut workspace, mut force) = (self.workspace(), vec![0.0; self.n_dofs()]);
        let rest = vec![0.0; self.n_dofs()];
        self.evaluate(
            &rest,
            Sticking::Coulomb,
            &untouched,
            &mut state,
            &mut workspace,
            &mut force,
            None,
        );
        state
    }

    /// Nodal forces (N) and, on request, the tangent (N/m) in the order of [`Interface::pattern`], from nodal jumps
    /// (m) (x, y, n of each node); what happens at the points is left in `workspace`.
    ///
    /// Pure in `begin`; `end` receives the history reached. Allocates nothing.
    ///
    /// # Panics
    /// If a slice has the wrong length or a state or workspace belongs to another interface.
    pub fn evaluate(
        &self,
        jump: &[f64],
        sticking: Sticking,
        begin: &State,
        end: &mut State,
        workspace: &mut Workspace,
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> RegimeCounts {
        assert_eq!(jump.len(), self.n_dofs());
        assert_eq!(force.len(), self.n_dofs());
        let q = &self.operators.interpolation;
        for (point, row) in q.outer_iterator().enumerate() {
            let mut sum = [0.0; 3];
            for (node, value) in row.iter() {
                for c in 0..3 {
                    sum[c] += value * jump[3 * node + c];
                }
            }
            workspace.jump[0][point] = sum[0];
            workspace.jump[1][point] = sum[1];
            workspace.jump[2][point] = sum[2] - self.gap[point];
        }
        let mut counts = RegimeCounts::default();
        let mut block = 0;
        for (range, law) in &self.laws {
            counts += evaluate_law(
                law.as_ref(),
                range,
                block,
                sticking,
                begin,
                end,
                workspace,
                tangent.is_some(),
            );
            block += range.len() * law.info().n_state();
        }
        for (node, row) in self.operators.integration.outer_iterator().enumerate() {
            let mut sum = [0.0; 3];
            for (point, area) in row.iter() {
                for c in 0..3 {
                    sum[c] += area * workspace.traction[c][point];
                }
            }
            force[3 * node..3 * node + 3].copy_from_slice(&sum);
        }
        if let Some(values) = tangent {
            self.assemble_tangent(workspace, values);
        }
        counts
    }

    /// `T D Q` over the pattern.
    fn assemble_tangent(&self, workspace: &Workspace, values: &mut [f64]) {
        assert_eq!(values.len(), self.pattern.indices.len());
        let q = &self.operators.interpolation;
        for (node, row) in self.operators.integration.outer_iterator().enumerate() {
            let list = &self.neighbours[node];
            let stride = 3 * list.len();
            let start = self.pattern.indptr[3 * node];
            let block_row = &mut values[start..start + 3 * stride];
            block_row.fill(0.0);
            for (point, area) in row.iter() {
                let range = q.indptr().outer_inds_sz(point);
                for (other, interpolation) in q.indices()[range.clone()].iter().zip(&q.data()[range]) {
                    // The neighbours of a node hold every node that shares a point with it.
                    let Ok(place) = list.binary_search(other) else { continue };
                    let factor = area * interpolation;
                    for i in 0..3 {
                        for j in 0..3 {
                            block_row[i * stride + 3 * place + j] += factor * workspace.tangent[3 * i + j][point];
                        }
                    }
                }
            }
        }
    }
}

impl std::fmt::Debug for Interface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Interface")
            .field("n_elements", &self.operators.n_elements())
            .field("n_points", &self.operators.n_points())
            .field(
                "laws",
                &self
                    .laws
                    .iter()
                    .map(|(range, law)| (range, law.info().name))
                    .collect::<Vec<_>>(),
            )
            .finish()
    }
}

fn check_gap(gap: &[f64], expected: usize) -> Result<(), Error> {
    if gap.len() != expected {
        return Err(Error::Coverage {
            what: "the gaps",
            found: gap.len(),
            expected,
        });
    }
    match gap.iter().position(|g| !(g.is_finite() && *g >= 0.0)) {
        Some(index) => Err(Error::Value {
            quantity: "gap",
            place: "quadrature point",
            index,
            value: gap[index],
            requirement: "finite and not negative",
        }),
        None => Ok(()),
    }
}

fn evaluate_law(
    law: &dyn TractionLaw,
    range: &Range<usize>,
    block: usize,
    sticking: Sticking,
    begin: &State,
    end: &mut State,
    workspace: &mut Workspace,
    with_tangent: bool,
) -> RegimeCounts {
    let Workspace {
        jump,
        traction,
        regime,
        tangent,
    } = workspace;
    let stride = range.len();
    let states = block..block + stride * law.info().n_state();
    let [x, y, n] = jump.each_ref().map(|v| &v[range.clone()]);
    let [tx, ty, tn] = traction.each_mut().map(|v| &mut v[range.clone()]);
    let entries = tangent.each_mut().map(|v| &mut v[range.clone()]);
    law.evaluate(
        0..stride,
        sticking,
        Components { x, y, n },
        StateView {
            data: &begin.values[states.clone()],
            stride,
            offset: 0,
        },
        StateViewMut {
            data: &mut end.values[states],
            stride,
            offset: 0,
        },
        ComponentsMut { x: tx, y: ty, n: tn },
        with_tangent.then_some(TangentMut::from_entries(entries)),
        Some(&mut regime[range.clone()]),
    )
}
