//! Forces and tangent of an interface from nodal jumps, with one traction law per range of quadrature points.

use crate::Error;
use crate::kernels::Blocks;
use crate::operators::Operators;
use contact_laws::{
    Adjoint, Components, ComponentsMut, LinearisedContact, PointSums, Regime, RegimeCounts, Scaling, Similarity,
    StateView, StateViewMut, Sticking, TangentMut, TractionLaw, WayBack, along_path,
};
use std::ops::Range;
use std::sync::Arc;

/// History of all points; opaque to solvers, which only swap and clone it.
#[derive(Debug)]
pub struct State {
    /// One block `[component][point]` per tile, one after the other.
    pub(crate) values: Vec<f64>,
    tiles: Vec<Stored>,
    /// Whether all values are known to be finite.
    is_finite: bool,
}

/// A tile of a [`State`].
#[derive(Clone, Debug)]
struct Stored {
    values: Range<usize>,
    n_points: usize,
    /// Components from this one on are known to be zero.
    zero_from: usize,
}

impl Stored {
    /// Values that need not be zero.
    fn kept(&self) -> Range<usize> {
        let kept = self.zero_from.saturating_mul(self.n_points);
        self.values.start..self.values.start + self.values.len().min(kept)
    }
}

/// Zeros are not read, and not touched where there are zeros already.
impl Clone for State {
    fn clone(&self) -> Self {
        let mut values = vec![0.0; self.values.len()];
        for kept in self.tiles.iter().map(Stored::kept) {
            values[kept.clone()].copy_from_slice(&self.values[kept]);
        }
        Self {
            values,
            tiles: self.tiles.clone(),
            is_finite: self.is_finite,
        }
    }

    fn clone_from(&mut self, source: &Self) {
        let [own, others] = [&*self, source].map(|state| state.tiles.iter().map(|tile| &tile.values));
        if !own.eq(others) {
            *self = source.clone();
            return;
        }
        for (own, source_tile) in self.tiles.iter_mut().zip(&source.tiles) {
            let (before, kept) = (own.kept(), source_tile.kept());
            self.values[kept.clone()].copy_from_slice(&source.values[kept.clone()]);
            self.values[kept.end..before.end.max(kept.end)].fill(0.0);
            own.clone_from(source_tile);
        }
        self.is_finite = source.is_finite;
    }
}

impl PartialEq for State {
    fn eq(&self, other: &Self) -> bool {
        self.values == other.values
    }
}

impl State {
    /// Sum of the products of all numbers: of an adjoint with a change.
    ///
    /// # Panics
    /// If they belong to different interfaces.
    pub fn product(&self, change: &Self) -> f64 {
        assert_eq!(self.values.len(), change.values.len());
        let of_tile = |tile: &Stored| {
            let [a, b] = [self, change].map(|state| &state.values[tile.kept()]);
            a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>()
        };
        self.tiles.iter().map(of_tile).sum()
    }

    /// `self += factor * change`.
    ///
    /// # Panics
    /// If they belong to different interfaces.
    pub fn add(&mut self, factor: f64, change: &Self) {
        assert_eq!(self.values.len(), change.values.len());
        let pairs = self.values.iter_mut().zip(&change.values);
        pairs.for_each(|(value, change)| *value += factor * change);
        for (own, change) in self.tiles.iter_mut().zip(&change.tiles) {
            own.zero_from = own.zero_from.max(change.zero_from);
        }
        self.is_finite = false;
    }
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
    /// A history, or a change of it, in other coordinates; empty until a parameter is asked for.
    history: Vec<f64>,
}

/// A step of a path: the history that it begins with, and what [`Interface::evaluate`] under friction has left of it.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// The history.
    pub begin: &'a State,
    /// What is left.
    pub workspace: &'a Workspace,
}

/// How a number grows with what parameters change at single points, as far as a path has been gone back along.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalGradient {
    /// What scales.
    sums: PointSums,
    /// Per unit of the gap (1/m).
    gap: Vec<f64>,
}

/// Change of an interface with a parameter, per unit of the parameter.
#[derive(Clone, Debug)]
pub struct Variation {
    /// Law by law.
    pub(crate) scalings: Vec<Scaling>,
    /// Of the gap at each point (m); empty if it does not change.
    pub(crate) gap: Vec<f64>,
}

impl Workspace {
    /// Row-major 3 x 3 tangent entries, one slice per entry (Pa/m), of the last evaluation that was asked for a tangent.
    pub fn tangent(&self) -> [&[f64]; 9] {
        self.tangent.each_ref().map(Vec::as_slice)
    }
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
    pub(crate) operators: Arc<Operators>,
    pub(crate) laws: Vec<(Range<usize>, Arc<dyn TractionLaw>)>,
    /// Less the interference of faces that are pressed together before they are loaded.
    gap: Vec<f64>,
    pattern: Arc<Pattern>,
    /// First value of the block of each ordered pair of an element's nodes, node by node, element by element.
    block_starts: Arc<Vec<usize>>,
    /// Whether a coordinate of the jump is held at zero; empty if none is.
    pub(crate) is_held: Arc<Vec<bool>>,
    /// Values of the pattern in the rows and columns of held coordinates.
    held_values: Arc<Vec<usize>>,
}

impl Interface {
    /// `laws` cover the points in order without holes; `gap` has one initial gap per point (m), at least zero; if all
    /// are zero it is not kept.
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
        let gap = checked("the gaps", "gap", gap, expected)?;
        let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); operators.n_nodes()];
        for (nodes, ..) in operators.elements() {
            for &node in nodes {
                neighbours[node as usize].extend_from_slice(nodes);
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
                let columns = list.iter().flat_map(|&node| (0..3).map(move |c| 3 * node as usize + c));
                pattern.indices.extend(columns);
                pattern.indptr.push(pattern.indices.len());
            }
        }
        let block_starts = Arc::new(block_starts(&operators, &neighbours, &pattern));
        let (is_held, held_values) = held(&operators, &pattern);
        Ok(Self {
            operators,
            laws,
            gap,
            pattern: Arc::new(pattern),
            block_starts,
            is_held: Arc::new(is_held),
            held_values: Arc::new(held_values),
        })
    }

    /// The same interface with another gap.
    ///
    /// # Errors
    /// As [`Interface::try_new`].
    pub fn with_gap(&self, gap: Vec<f64>) -> Result<Self, Error> {
        let gap = checked("the gaps", "gap", gap, self.operators.n_points())?;
        Ok(Self { gap, ..self.clone() })
    }

    /// The interface with every law linearised about a static state ([`contact_laws::friction::linearised`]), given by the nodal
    /// jumps (m) and the history committed there; and the history that is the static state
    /// for it.
    ///
    /// # Errors
    /// [`Error::Law`] where the static state is not finite or a law has no friction coefficient.
    ///
    /// # Panics
    /// As [`Interface::evaluate`].
    pub fn linearised(&self, jump: &[f64], state: &State) -> Result<(Self, State), Error> {
        let mut workspace = self.workspace();
        let mut force = vec![0.0; self.n_dofs()];
        let mut end = state.clone();
        self.evaluate(
            jump,
            Sticking::Coulomb,
            state,
            &mut end,
            &mut workspace,
            &mut force,
            None,
        );
        let mut laws: Vec<(Range<usize>, Arc<dyn TractionLaw>)> = Vec::new();
        let mut block = 0;
        for (index, (range, law)) in self.laws.iter().enumerate() {
            let [x, y, n] = workspace.jump.each_ref().map(|u| &u[range.clone()]);
            let mut history = vec![0.0; range.len() * law.info().n_state()];
            self.copy_history(index, block, 0..range.len(), state, &mut history);
            block += history.len();
            let history = StateView::new(&history, range.len(), 0);
            let linear = LinearisedContact::about(law.as_ref(), Components { x, y, n }, history)?;
            laws.push((range.clone(), Arc::new(linear)));
        }
        let linear = Self { laws, ..self.clone() };
        let at_rest = linear.no_change();
        Ok((linear, at_rest))
    }

    /// The same interface with faces that are pressed into one another at zero jump: one interference per quadrature point (m), at
    /// least zero, which is taken off the gap. A law then starts from the pressure that belongs to it.
    ///
    /// # Errors
    /// Interferences of another number than the points, negative ones and ones that are not finite.
    pub fn with_interference(&self, interference: Vec<f64>) -> Result<Self, Error> {
        let expected = self.operators.n_points();
        let interference = checked("the interferences", "interference", interference, expected)?;
        let mut gap = match self.gap() {
            Some(gap) => gap.to_vec(),
            None => vec![0.0; interference.len()],
        };
        gap.iter_mut().zip(&interference).for_each(|(gap, own)| *gap -= own);
        Ok(Self { gap, ..self.clone() })
    }

    /// The points of each law, in order.
    pub fn points_of_laws(&self) -> impl Iterator<Item = Range<usize>> {
        self.laws.iter().map(|(points, _)| points.clone())
    }

    /// Geometry and quadrature.
    pub fn operators(&self) -> &Operators {
        &self.operators
    }

    /// Initial gap of each point (m), if there is any; negative where the faces are pressed into one another at zero jump.
    pub fn gap(&self) -> Option<&[f64]> {
        (!self.gap.is_empty()).then_some(&self.gap)
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

    /// Whether any point can slip in parts ([`TractionLaw::slips_in_parts`]).
    pub fn slips_in_parts(&self) -> bool {
        self.laws.iter().any(|(_, law)| law.slips_in_parts())
    }

    /// Whether friction can take energy at any point ([`TractionLaw::dissipates`]).
    pub fn dissipates(&self) -> bool {
        self.laws.iter().any(|(_, law)| law.dissipates())
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
            history: Vec::new(),
        }
    }

    /// A parameter that scales the laws as `points` has it for each point, and changes the gap by `gap` (m per unit of the parameter; empty if
    /// it does not). `None` where a law is not scaled by such factors.
    ///
    /// # Errors
    /// Lists of another length than the points.
    pub fn variation(&self, points: &[Similarity], gap: Vec<f64>) -> Result<Option<Variation>, Error> {
        let expected = self.operators.n_points();
        for (what, found) in [
            ("the similarities", points.len()),
            ("the changes of the gap", gap.len()),
        ] {
            if found != expected && !(what == "the changes of the gap" && found == 0) {
                return Err(Error::Coverage { what, found, expected });
            }
        }
        let scalings = self.laws.iter().map(|(range, law)| {
            let points = points[range.clone()].to_vec();
            Scaling::try_new(law.as_ref(), points)
        });
        let scalings: Option<Vec<Scaling>> = scalings.collect();
        Ok(scalings.map(|scalings| Variation { scalings, gap }))
    }

    /// The history of bodies that rest at zero jump, separated by the gap or pressed into one another.
    pub fn initial_state(&self) -> State {
        let untouched = self.no_change();
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
    /// Pure in `begin`; `end` receives the history reached. Allocates nothing. Sums run in the order of the elements
    /// and of their points.
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
        self.interpolate_jump(jump, workspace);
        let mut counts = RegimeCounts::default();
        for tile in self.tiles() {
            counts += tile.evaluate(sticking, begin, end, workspace, tangent.is_some());
        }
        self.integrate(workspace.traction.each_ref().map(Vec::as_slice), force);
        // A law spoils tractions and history together.
        end.is_finite = are_finite(force);
        if let Some(values) = tangent {
            self.assemble_tangent(workspace.tangent.each_ref().map(Vec::as_slice), values);
        }
        counts
    }

    /// Nodal forces (N) at the vertices of a path of nodal jumps (m), which begins with the history `begin`: those of [`Interface::evaluate`] from one
    /// vertex to the next. No more histories are held than those of a few points.
    ///
    /// # Panics
    /// As [`Interface::evaluate`].
    pub fn along_path(&self, path: &[Vec<f64>], sticking: Sticking, begin: &State) -> Vec<Vec<f64>> {
        let mut workspace = self.workspace();
        let jumps: Vec<[Vec<f64>; 3]> = path
            .iter()
            .map(|jump| {
                self.interpolate_jump(jump, &mut workspace);
                workspace.jump.clone()
            })
            .collect();
        let mut tractions = jumps.clone();
        let [mut history, mut room, mut at, mut found] = [(); 4].map(|()| Vec::new());
        for tile in self.tiles() {
            let (n, points) = (tile.points.len(), &tile.points);
            history.clear();
            history.extend_from_slice(&begin.values[tile.states.clone()]);
            room.resize(history.len(), 0.0);
            at.clear();
            jumps
                .iter()
                .flatten()
                .for_each(|values| at.extend_from_slice(&values[points.clone()]));
            found.resize(at.len(), 0.0);
            along_path(
                n,
                &at,
                &mut history,
                &mut room,
                &mut found,
                |jump, begin, end, traction| {
                    tile.law
                        .evaluate(tile.of_law.clone(), sticking, jump, begin, end, traction, None, None);
                },
            );
            let fields = tractions.iter_mut().flatten().zip(found.chunks_exact(n));
            fields.for_each(|(values, found)| values[points.clone()].copy_from_slice(found));
        }
        let forces = tractions.iter().map(|traction| {
            let mut force = vec![0.0; self.n_dofs()];
            self.integrate(traction.each_ref().map(Vec::as_slice), &mut force);
            force
        });
        forces.collect()
    }

    /// What [`Interface::evaluate`] gives, and its change along a direction of nodal jumps `d_jump` (m) and history `d_begin`: `d_force` and
    /// `d_end` ([`TractionLaw::derivative`]). With a `variation` the parameter changes by one beside them.
    ///
    /// # Panics
    /// As [`Interface::evaluate`].
    pub fn derivative(
        &self,
        jump: &[f64],
        sticking: Sticking,
        begin: &State,
        d_jump: &[f64],
        d_begin: &State,
        variation: Option<&Variation>,
        end: &mut State,
        d_end: &mut State,
        workspace: &mut Workspace,
        force: &mut [f64],
        d_force: &mut [f64],
    ) {
        assert_eq!(jump.len(), self.n_dofs());
        assert_eq!(d_jump.len(), self.n_dofs());
        self.interpolate_jump(jump, workspace);
        let Workspace {
            jump: at_points,
            traction,
            tangent: [d_x, d_y, d_n, d_tx, d_ty, d_tn, ..],
            history,
            ..
        } = workspace;
        self.interpolate(d_jump, [&mut *d_x, &mut *d_y, &mut *d_n]);
        if let Some(variation) = variation {
            d_n.iter_mut().zip(&variation.gap).for_each(|(n, gap)| *n -= gap);
            history.clear();
            history.extend_from_slice(&d_begin.values);
        }
        for tile in self.tiles() {
            let range = &tile.points;
            let [x, y, n] = at_points.each_ref().map(|v| &v[range.clone()]);
            let [tx, ty, tn] = traction.each_mut().map(|v| &mut v[range.clone()]);
            let [dx, dy, dn] = [&mut *d_x, &mut *d_y, &mut *d_n].map(|v| &mut v[range.clone()]);
            let [dtx, dty, dtn] = [&mut *d_tx, &mut *d_ty, &mut *d_tn].map(|v| &mut v[range.clone()]);
            let (begin, end, changed) = (tile.history(begin), tile.history_mut(end), tile.history_mut(d_end));
            match variation {
                Some(variation) => variation.scalings[tile.index].derivative(
                    tile.law,
                    tile.of_law,
                    sticking,
                    Components { x, y, n },
                    begin,
                    ComponentsMut::new(dx, dy, dn),
                    &mut history[tile.states],
                    end,
                    changed,
                    ComponentsMut { x: tx, y: ty, n: tn },
                    ComponentsMut::new(dtx, dty, dtn),
                ),
                None => {
                    tile.law.derivative(
                        tile.of_law.clone(),
                        sticking,
                        Components { x, y, n },
                        begin,
                        Components::new(dx, dy, dn),
                        tile.history(d_begin),
                        end,
                        changed,
                        ComponentsMut { x: tx, y: ty, n: tn },
                        ComponentsMut::new(dtx, dty, dtn),
                    );
                }
            }
        }
        self.integrate(traction.each_ref().map(Vec::as_slice), force);
        self.integrate([d_tx, d_ty, d_tn], d_force);
        end.is_finite = are_finite(force);
        d_end.is_finite = end.is_finite && are_finite(d_force);
    }

    /// The way back through a step under friction: what the product of adjoints of the end state with the end state, less that of adjoints of the
    /// nodal forces with these, grows by. It is given per unit of the nodal jumps, `to_jumps`, of the begin state, for which `adjoints` are
    /// overwritten as `way` has it, and added to `gradients`, but for [`Interface::at_start`]. Without adjoints of forces, `forces` is
    /// empty. Of the step `before`, what the adjoints left at its end give per unit of its nodal jumps ([`WayBack::JumpAlone`]) is found along with them,
    /// while they are at hand: all of them together are read from memory, and this takes longer than the arithmetic.
    ///
    /// # Panics
    /// As [`Interface::evaluate`].
    pub fn transposed(
        &self,
        Step { begin, workspace }: Step<'_>,
        way: WayBack,
        adjoints: &mut [State],
        forces: &[Vec<f64>],
        to_jumps: &mut [Vec<f64>],
        gradients: &mut [LocalGradient],
        before: Option<(Step<'_>, &mut [Vec<f64>])>,
    ) {
        let n = self.operators.n_points();
        let weights = &self.operators.weights;
        let zeros = || -> [Vec<f64>; 3] { std::array::from_fn(|_| vec![0.0; n]) };
        let mut fields: Vec<[Vec<f64>; 3]> = adjoints.iter().map(|_| zeros()).collect();
        let mut fields_before = fields.clone();
        let mut tractions = fields.clone();
        let untouched = zeros();
        for (force, fields) in forces.iter().zip(&mut tractions) {
            self.interpolate(&force[..self.n_dofs()], fields.each_mut().map(Vec::as_mut_slice));
            for values in fields {
                values.iter_mut().zip(weights).for_each(|(v, w)| *v *= -w);
            }
        }
        for tile in self.tiles() {
            let (range, of_law) = (&tile.points, &tile.of_law);
            let along = adjoints.iter_mut().zip(&tractions).zip(&mut fields);
            let along = along.map(|((history, traction), jump)| tile.adjoint(history, traction, jump));
            let mut along: Vec<Adjoint<'_>> = along.collect();
            let [jump, traction] = [&workspace.jump, &workspace.traction].map(|fields| components(fields, range));
            tile.law
                .transposed(of_law.clone(), jump, tile.history(begin), way, &mut along);
            for (adjoint, gradient) in along.iter().zip(&mut *gradients) {
                gradient.sums.add_step(range.clone(), jump, traction, adjoint);
            }
            if let Some((Step { begin, workspace }, _)) = &before {
                let along = adjoints.iter_mut().zip(&mut fields_before);
                let along = along.map(|(history, jump)| tile.adjoint(history, &untouched, jump));
                let mut along: Vec<Adjoint<'_>> = along.collect();
                let (jump, begin) = (components(&workspace.jump, range), tile.history(begin));
                tile.law
                    .transposed(of_law.clone(), jump, begin, WayBack::JumpAlone, &mut along);
            }
        }
        for ([.., normal], gradient) in fields.iter().zip(gradients) {
            gradient.gap.iter_mut().zip(normal).for_each(|(sum, own)| *sum -= own);
        }
        let to_jumps_before = before.map_or_else(Default::default, |(_, to_jumps)| to_jumps);
        let own = fields.iter_mut().zip(to_jumps);
        for (field, into) in own.chain(fields_before.iter_mut().zip(to_jumps_before)) {
            // The forces of tractions are weighted sums.
            for values in field.iter_mut() {
                values.iter_mut().zip(weights).for_each(|(v, w)| *v /= w);
            }
            self.integrate(field.each_ref().map(Vec::as_slice), into);
        }
    }

    /// Before the way back along a path.
    pub fn no_gradient(&self) -> LocalGradient {
        let n = self.operators.n_points();
        LocalGradient {
            sums: PointSums::new(n),
            gap: vec![0.0; n],
        }
    }

    /// Adds what [`Interface::transposed`] leaves of all steps of a path, by the history that the path begins with and the adjoint of that.
    pub fn at_start(&self, begin: &State, adjoint: &State, gradient: &mut LocalGradient) {
        for tile in self.tiles() {
            let kept = begin.tiles[tile.number].kept();
            let [begin, adjoint] = [begin, adjoint].map(|state| &state.values[kept.clone()]);
            let state = &tile.law.info().state;
            gradient.sums.add_begin(tile.points, state, begin, adjoint);
        }
    }

    /// How much of it a parameter takes.
    pub fn of_parameter(&self, gradient: &LocalGradient, variation: &Variation) -> f64 {
        let of_laws = self.laws.iter().zip(&variation.scalings);
        let scaled = of_laws.map(|((range, _), scaling)| scaling.of_path(&gradient.sums, range.start));
        let gap = gradient.gap.iter().zip(&variation.gap).map(|(own, gap)| own * gap);
        scaled.sum::<f64>() + gap.sum::<f64>()
    }

    /// The tangent (N/m) with everything stuck at nodal jumps (m), a history, and the value of a parameter plus `step`.
    ///
    /// # Panics
    /// As [`Interface::evaluate`].
    pub fn stuck_tangent_at(
        &self,
        jump: &[f64],
        begin: &State,
        variation: Option<(&Variation, f64)>,
        workspace: &mut Workspace,
        values: &mut [f64],
    ) {
        self.interpolate_jump(jump, workspace);
        let mut begin = begin.clone();
        let mut end = self.no_change();
        for tile in self.tiles() {
            let (index, range) = (tile.index, &tile.points);
            if let Some((variation, step)) = variation {
                let part = workspace.jump.each_mut().map(|v| &mut v[range.clone()]);
                if !variation.gap.is_empty() {
                    let gap = &variation.gap[range.clone()];
                    part[2].iter_mut().zip(gap).for_each(|(n, gap)| *n -= step * gap);
                }
                begin.tiles[tile.number].zero_from = usize::MAX;
                let history = &mut begin.values[tile.states.clone()];
                variation.scalings[index].transform(tile.of_law.clone(), step, part, history);
                begin.is_finite = false;
            }
            tile.evaluate(Sticking::Full, &begin, &mut end, workspace, true);
            if let Some((variation, step)) = variation {
                let part = workspace.tangent.each_mut().map(|v| &mut v[range.clone()]);
                variation.scalings[index].transform_tangent(tile.of_law, step, part);
            }
        }
        self.assemble_tangent(workspace.tangent.each_ref().map(Vec::as_slice), values);
    }

    /// A history of zeros: no change, as a direction.
    pub fn no_change(&self) -> State {
        let tiles: Vec<Stored> = self
            .tiles()
            .map(|tile| Stored {
                values: tile.states,
                n_points: tile.points.len(),
                zero_from: 0,
            })
            .collect();
        State {
            values: vec![0.0; tiles.last().map_or(0, |tile| tile.values.end)],
            tiles,
            is_finite: true,
        }
    }

    /// The points with their histories.
    fn tiles(&self) -> impl Iterator<Item = Tile<'_>> {
        let (mut block, mut count) = (0, 0);
        self.laws.iter().enumerate().flat_map(move |(index, (range, law))| {
            let (first, before, n_state) = (block, count, law.info().n_state());
            block += range.len() * n_state;
            count += range.len().div_ceil(TILE);
            (0..range.len()).step_by(TILE).map(move |start| {
                let of_law = start..range.len().min(start + TILE);
                Tile {
                    number: before + start / TILE,
                    index,
                    law: law.as_ref(),
                    points: range.start + of_law.start..range.start + of_law.end,
                    states: first + of_law.start * n_state..first + of_law.end * n_state,
                    of_law,
                }
            })
        })
    }

    /// Copies the history of some points of a law, whose histories begin at `block`, as `[component][point]`.
    pub(crate) fn copy_history(&self, law: usize, block: usize, of_law: Range<usize>, state: &State, into: &mut [f64]) {
        let (range, law) = &self.laws[law];
        let n_state = law.info().n_state();
        let first = of_law.start - of_law.start % TILE;
        for start in (first..of_law.end).step_by(TILE) {
            let tile = start..range.len().min(start + TILE);
            let own = of_law.start.max(tile.start)..of_law.end.min(tile.end);
            for component in 0..n_state {
                let at = block + n_state * tile.start + component * tile.len() + own.start - tile.start;
                let to = component * of_law.len() + own.start - of_law.start;
                into[to..to + own.len()].copy_from_slice(&state.values[at..at + own.len()]);
            }
        }
    }

    /// `Q u - gap`.
    fn interpolate_jump(&self, jump: &[f64], workspace: &mut Workspace) {
        self.interpolate(jump, workspace.jump.each_mut().map(Vec::as_mut_slice));
        let normal = &mut workspace.jump[2];
        normal.iter_mut().zip(&self.gap).for_each(|(n, gap)| *n -= gap);
    }

    /// `T D Q` over the pattern.
    pub(crate) fn assemble_tangent(&self, tangent: [&[f64]; 9], values: &mut [f64]) {
        assert_eq!(values.len(), self.pattern.indices.len());
        values.fill(0.0);
        let mut starts = self.block_starts.as_slice();
        for (nodes, points, shape) in self.operators.elements() {
            let weights = &self.operators.weights[points.clone()];
            let tangent = tangent.map(|field| &field[points.clone()]);
            let (of_element, rest) = starts.split_at(nodes.len() * nodes.len());
            starts = rest;
            let blocks = Blocks {
                nodes,
                indptr: &self.pattern.indptr,
                starts: of_element,
            };
            (shape.shape.kernels.integrate_tangent)(&shape.products, weights, tangent, blocks, values);
        }
        for &value in &*self.held_values {
            values[value] = 0.0;
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

/// Values of some points.
fn components<'a>(fields: &'a [Vec<f64>; 3], points: &Range<usize>) -> Components<'a> {
    let [x, y, n] = fields.each_ref().map(|field| &field[points.clone()]);
    Components { x, y, n }
}

/// First value of the block of each ordered pair of an element's nodes.
fn block_starts(operators: &Operators, neighbours: &[Vec<u32>], pattern: &Pattern) -> Vec<usize> {
    let mut starts = Vec::new();
    for (nodes, ..) in operators.elements() {
        for &node in nodes {
            starts.extend(nodes.iter().map(|other| {
                let before = neighbours[node as usize].partition_point(|n| n < other);
                pattern.indptr[3 * node as usize] + 3 * before
            }));
        }
    }
    starts
}

/// Which coordinates are held, and the values of the pattern in their rows or columns.
fn held(operators: &Operators, pattern: &Pattern) -> (Vec<bool>, Vec<usize>) {
    let held = operators.held();
    if held.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let mut is_held = vec![false; 3 * operators.n_nodes()];
    held.iter().for_each(|&coordinate| is_held[coordinate] = true);
    let of = |coordinate: usize| is_held[coordinate];
    let rows = pattern.indptr.windows(2).enumerate();
    let values = rows
        .flat_map(|(row, ends)| (ends[0]..ends[1]).filter(move |&at| of(row) || of(pattern.indices[at])))
        .collect();
    (is_held, values)
}

/// One length per point that is not negative, none if all are zero; `what` are they, and `quantity` is one of them.
fn checked(what: &'static str, quantity: &'static str, lengths: Vec<f64>, expected: usize) -> Result<Vec<f64>, Error> {
    if lengths.len() != expected {
        return Err(Error::Coverage {
            what,
            found: lengths.len(),
            expected,
        });
    }
    match lengths.iter().position(|g| !(g.is_finite() && *g >= 0.0)) {
        Some(index) => Err(Error::Value {
            quantity,
            place: "quadrature point",
            index,
            value: lengths[index],
            requirement: "finite and not negative",
        }),
        None if lengths.iter().all(|g| *g == 0.0) => Ok(Vec::new()),
        None => Ok(lengths),
    }
}

/// Most points whose histories stand together: with those of thousands a block of points would have each number of its history on another page of
/// memory.
pub(crate) const TILE: usize = 64;

fn are_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

/// Points of one law whose histories are one block `[component][point]`.
struct Tile<'a> {
    /// Its own number.
    number: usize,
    /// Number of the law.
    index: usize,
    law: &'a dyn TractionLaw,
    /// In the interface.
    points: Range<usize>,
    /// In the law.
    of_law: Range<usize>,
    /// In the values of a [`State`].
    states: Range<usize>,
}

impl Tile<'_> {
    fn history<'s>(&self, of: &'s State) -> StateView<'s> {
        StateView::new(&of.values[self.states.clone()], self.points.len(), 0)
            .known_finite(of.is_finite)
            .with_zeros_from(of.tiles[self.number].zero_from)
    }

    fn history_mut<'s>(&self, of: &'s mut State) -> StateViewMut<'s> {
        // Until whoever writes it says so.
        of.is_finite = false;
        StateViewMut::new(&mut of.values[self.states.clone()], self.points.len(), 0)
            .with_zeros_from(&mut of.tiles[self.number].zero_from)
    }

    fn adjoint<'s>(
        &self,
        history: &'s mut State,
        traction: &'s [Vec<f64>; 3],
        jump: &'s mut [Vec<f64>; 3],
    ) -> Adjoint<'s> {
        let [x, y, n] = jump.each_mut().map(|values| &mut values[self.points.clone()]);
        Adjoint {
            history: self.history_mut(history),
            traction: components(traction, &self.points),
            jump: ComponentsMut { x, y, n },
        }
    }

    fn evaluate(
        &self,
        sticking: Sticking,
        begin: &State,
        end: &mut State,
        workspace: &mut Workspace,
        with_tangent: bool,
    ) -> RegimeCounts {
        let Self {
            law, points, of_law, ..
        } = self;
        let Workspace {
            jump,
            traction,
            regime,
            tangent,
            ..
        } = workspace;
        let [tx, ty, tn] = traction.each_mut().map(|v| &mut v[points.clone()]);
        let entries = tangent.each_mut().map(|v| &mut v[points.clone()]);
        law.evaluate(
            of_law.clone(),
            sticking,
            components(jump, points),
            self.history(begin),
            self.history_mut(end),
            ComponentsMut { x: tx, y: ty, n: tn },
            with_tangent.then_some(TangentMut::from_entries(entries)),
            Some(&mut regime[points.clone()]),
        )
    }
}
