//! The adapter through which the solver sees an interface.

use contact_laws::{RegimeCounts, Sticking};
use cqsma_solver::{HystereticForce, PatternView};
use zte_assembly::{Interface, State, Workspace};

/// The interface as the solver sees it.
pub struct InterfaceForce<'a> {
    interface: &'a Interface,
    friction: Sticking,
}

impl<'a> InterfaceForce<'a> {
    /// Wraps an interface.
    pub fn new(interface: &'a Interface) -> Self {
        Self {
            interface,
            friction: Sticking::Coulomb,
        }
    }

    /// The same without friction, wherever the solver asks for it.
    #[must_use]
    pub fn frictionless(interface: &'a Interface) -> Self {
        Self {
            interface,
            friction: Sticking::Frictionless,
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
        let sticking = match sticking {
            Sticking::Full => Sticking::Full,
            Sticking::Coulomb | Sticking::Frictionless => self.friction,
        };
        self.interface
            .evaluate(u, sticking, begin, end, workspace, force, tangent)
    }
}
