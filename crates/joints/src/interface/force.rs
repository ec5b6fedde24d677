//! The adapter through which the solver sees an interface.

use contact_laws::{Components, ComponentsMut, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut, WayBack};
use cqsma_solver::{DifferentiableForce, HystereticForce, PatternView, Reflection, Step};
use finite_elements::reflection::Places;
use harmonic_balance::{DifferentiablePointwiseForce, PointwiseForce};
use std::ops::Range;
use zte_assembly::{Batches, Interface, LocalGradient, State, Variation, Workspace};

/// The interface as the solver sees it.
pub struct InterfaceForce<'a> {
    interface: &'a Interface,
    friction: Sticking,
    batches: Batches,
}

impl<'a> InterfaceForce<'a> {
    /// Wraps an interface.
    pub fn new(interface: &'a Interface) -> Self {
        Self {
            interface,
            friction: Sticking::Coulomb,
            batches: interface.batches(),
        }
    }

    /// The same without friction, wherever the solver asks for it.
    #[must_use]
    pub fn frictionless(interface: &'a Interface) -> Self {
        Self {
            friction: Sticking::Frictionless,
            ..Self::new(interface)
        }
    }

    /// What is evaluated where the solver asks for `wanted`.
    fn sticking(&self, wanted: Sticking) -> Sticking {
        match wanted {
            Sticking::Full => Sticking::Full,
            Sticking::Coulomb | Sticking::Frictionless => self.friction,
        }
    }

    /// The interface.
    pub fn interface(&self) -> &Interface {
        self.interface
    }
}

impl HystereticForce for InterfaceForce<'_> {
    type State = State;
    type Workspace = Workspace;

    fn n_dofs(&self) -> usize {
        self.interface.n_dofs()
    }

    fn pattern(&self) -> PatternView<'_> {
        let pattern = self.interface.pattern();
        PatternView {
            indptr: &pattern.indptr,
            indices: &pattern.indices,
        }
    }

    fn initial_state(&self) -> State {
        self.interface.initial_state()
    }

    fn workspace(&self) -> Workspace {
        self.interface.workspace()
    }

    fn reflections(&self) -> Vec<Reflection> {
        let flat: Vec<[f64; 3]> = self
            .interface
            .operators()
            .places()
            .into_iter()
            .map(|[x, y]| [x, y, 0.0])
            .collect();
        let Some(places) = Places::try_new(&flat) else {
            return Vec::new();
        };
        let one_body = vec![0; flat.len()];
        let of_jump = |axis: usize| {
            let images = places.images(&one_body, axis)?;
            let components = images
                .into_iter()
                .flat_map(|node| (0..3).map(move |c| (3 * node + c, if c == axis { -1.0 } else { 1.0 })));
            Reflection::try_new(components.collect())
        };
        (0..2).filter_map(of_jump).collect()
    }

    fn slips_in_parts(&self) -> bool {
        self.interface.slips_in_parts()
    }

    fn dissipates(&self) -> bool {
        self.friction == Sticking::Coulomb && self.interface.dissipates()
    }

    fn evaluate(
        &self,
        u: &[f64],
        sticking: Sticking,
        begin: &State,
        end: &mut State,
        workspace: &mut Workspace,
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> RegimeCounts {
        self.interface
            .evaluate(u, self.sticking(sticking), begin, end, workspace, force, tangent)
    }
}

impl DifferentiableForce for InterfaceForce<'_> {
    type Parameter = Variation;
    type LocalGradient = LocalGradient;

    fn derivative(
        &self,
        u: &[f64],
        sticking: Sticking,
        begin: &State,
        d_u: &[f64],
        d_begin: &State,
        parameter: Option<&Variation>,
        end: &mut State,
        d_end: &mut State,
        workspace: &mut Workspace,
        force: &mut [f64],
        d_force: &mut [f64],
    ) {
        self.interface.derivative(
            u,
            self.sticking(sticking),
            begin,
            d_u,
            d_begin,
            parameter,
            end,
            d_end,
            workspace,
            force,
            d_force,
        );
    }

    fn initial_change(&self, parameter: &Variation) -> State {
        let (none, mut end, mut change) = (self.no_change(), self.no_change(), self.no_change());
        let at_rest = vec![0.0; self.n_dofs()];
        let (mut force, mut d_force) = (at_rest.clone(), at_rest.clone());
        self.interface.derivative(
            &at_rest,
            Sticking::Coulomb,
            &none,
            &at_rest,
            &none,
            Some(parameter),
            &mut end,
            &mut change,
            &mut self.workspace(),
            &mut force,
            &mut d_force,
        );
        change
    }

    fn stuck_tangent(
        &self,
        u: &[f64],
        begin: &State,
        parameter: Option<(&Variation, f64)>,
        workspace: &mut Workspace,
        tangent: &mut [f64],
    ) {
        self.interface.stuck_tangent_at(u, begin, parameter, workspace, tangent);
    }

    fn transposed(
        &self,
        step: Step<'_, Self>,
        way: WayBack,
        adjoints: &mut [State],
        forces: &[Vec<f64>],
        to_displacements: &mut [Vec<f64>],
        gradients: &mut [LocalGradient],
        before: Option<(Step<'_, Self>, &mut [Vec<f64>])>,
    ) {
        let of_interface = |Step { begin, workspace, .. }| zte_assembly::Step { begin, workspace };
        let before = before.map(|(step, to_displacements)| (of_interface(step), to_displacements));
        self.interface.transposed(
            of_interface(step),
            way,
            adjoints,
            forces,
            to_displacements,
            gradients,
            before,
        );
    }

    fn no_gradient(&self) -> LocalGradient {
        self.interface.no_gradient()
    }

    fn at_start(&self, begin: &State, adjoint: &State, gradient: &mut LocalGradient) {
        self.interface.at_start(begin, adjoint, gradient);
    }

    fn of_parameter(&self, gradient: &LocalGradient, parameter: &Variation) -> f64 {
        self.interface.of_parameter(gradient, parameter)
    }

    fn product(&self, adjoint: &State, change: &State) -> f64 {
        adjoint.product(change)
    }

    fn no_change(&self) -> State {
        self.interface.no_change()
    }

    fn add_change(&self, state: &mut State, factor: f64, change: &State) {
        state.add(factor, change);
    }
}

impl PointwiseForce for InterfaceForce<'_> {
    fn n_points(&self) -> usize {
        self.interface.operators().n_points()
    }

    fn batches(&self) -> &[Range<usize>] {
        self.batches.points()
    }

    fn n_state(&self, batch: usize) -> usize {
        self.interface.batch_states(&self.batches, batch)
    }

    fn state_of(&self, batch: usize, state: &State, into: &mut [f64]) {
        self.interface.copy_state(&self.batches, batch, state, into);
    }

    fn jumps(&self, u: &[f64], jump: [&mut [f64]; 3]) {
        self.interface.interpolate(u, jump);
    }

    fn subtract_gap(&self, jump_n: &mut [f64]) {
        let gap = self.interface.gap().unwrap_or_default();
        jump_n.iter_mut().zip(gap).for_each(|(n, gap)| *n -= gap);
    }

    fn forces(&self, traction: [&[f64]; 3], force: &mut [f64]) {
        self.interface.integrate(traction, force);
    }

    fn weights(&self) -> &[f64] {
        &self.interface.operators().weights
    }

    fn evaluate_batch(
        &self,
        batch: usize,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        tangent: Option<TangentMut<'_>>,
    ) {
        let (batches, friction) = (&self.batches, self.friction);
        self.interface
            .evaluate_batch(batches, batch, friction, jump, begin, end, traction, tangent);
    }

    fn follow_batch(&self, batch: usize, path: &[f64], state: &mut [f64], room: &mut [f64], traction: &mut [f64]) {
        self.interface
            .follow_batch(&self.batches, batch, self.friction, path, state, room, traction);
    }

    fn assemble_tangent(&self, tangent: [&[f64]; 9], values: &mut [f64]) {
        self.interface.integrate_tangent(tangent, values);
    }

    fn derivative_batch(
        &self,
        batch: usize,
        jump: Components<'_>,
        begin: StateView<'_>,
        d_jump: Components<'_>,
        d_begin: StateView<'_>,
        end: StateViewMut<'_>,
        d_end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        d_traction: ComponentsMut<'_>,
    ) {
        self.interface.derivative_batch(
            &self.batches,
            batch,
            self.friction,
            jump,
            begin,
            d_jump,
            d_begin,
            end,
            d_end,
            traction,
            d_traction,
        );
    }
}

impl DifferentiablePointwiseForce for InterfaceForce<'_> {
    fn parameter_batch(
        &self,
        batch: usize,
        parameter: &Variation,
        jump: Components<'_>,
        begin: StateView<'_>,
        d_jump: ComponentsMut<'_>,
        d_begin: &mut [f64],
        end: StateViewMut<'_>,
        d_end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        d_traction: ComponentsMut<'_>,
    ) {
        self.interface.parameter_batch(
            &self.batches,
            batch,
            self.friction,
            parameter,
            jump,
            begin,
            d_jump,
            d_begin,
            end,
            d_end,
            traction,
            d_traction,
        );
    }
}
