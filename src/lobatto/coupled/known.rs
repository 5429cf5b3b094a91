//! Properties of the closures that kinematics determines before any solve ([`catena_mechanism::structure::ranks`]).

/// The flags of the closures: empty equations, still freedoms, and the inertia lent to light ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// For every equation of the loops whether it is empty: its gradient is rounding, so motions do not change it. Such an equation has no scale of
    /// its own.
    pub empty: Vec<bool>,
    /// For every equation whether the others imply it in the run; empty if all are independent, or if this is unknown.
    pub implied: Vec<bool>,
    /// For every equation whether friction would hold it and the others without friction imply it; empty as above.
    pub borne: Vec<bool>,
    /// For every freedom whether it cannot move; empty if all can.
    pub still: Vec<bool>,
    /// For every freedom whether it and all freedoms that closures tie to it cannot move; empty if all can move.
    pub locked: Vec<bool>,
    /// Inertia that the matrix has besides the inertia of the bodies, for every freedom [kg m² or kg]; empty if it is zero.
    pub lent: Vec<f64>,
    /// Number of independent equations that are weak at the start of the steps: a singular position makes them redundant.
    pub weak: usize,
}

impl Known {
    /// Copies another's flags. Does not allocate once it has.
    pub fn copy_from(&mut self, other: &Known) {
        self.empty.clone_from(&other.empty);
        self.implied.clone_from(&other.implied);
        self.borne.clone_from(&other.borne);
        self.still.clone_from(&other.still);
        self.locked.clone_from(&other.locked);
        self.lent.clone_from(&other.lent);
        self.weak = other.weak;
    }

    /// The flags of the freedoms alone, because a plane and space have different equations.
    pub fn of_freedoms(&self) -> Known {
        Known { empty: Vec::new(), implied: Vec::new(), borne: Vec::new(), ..self.clone() }
    }

    /// Inertia lent to a freedom.
    #[inline(always)]
    pub fn lent_to(&self, freedom: usize) -> f64 {
        self.lent.get(freedom).copied().unwrap_or(0.0)
    }

    /// Whether an equation is empty.
    pub fn is_empty(&self, row: usize) -> bool {
        self.empty.get(row).copied().unwrap_or(false)
    }

    /// Whether the others imply an equation.
    pub fn is_implied(&self, row: usize) -> bool {
        self.implied.get(row).copied().unwrap_or(false)
    }

    /// Whether equations without friction imply one that friction would hold.
    pub fn is_borne(&self, row: usize) -> bool {
        self.borne.get(row).copied().unwrap_or(false)
    }

    /// The freedoms that cannot move.
    pub fn still_freedoms(&self) -> impl Iterator<Item = usize> {
        numbers(&self.still)
    }

    /// The freedoms that cannot move, nor anything that closures tie to them: not even roundings of gaps have to be made up for.
    pub fn locked_freedoms(&self) -> impl Iterator<Item = usize> {
        numbers(&self.locked)
    }
}

/// The indices of the flags that are set.
fn numbers(flags: &[bool]) -> impl Iterator<Item = usize> {
    flags.iter().enumerate().filter_map(|(number, &flag)| flag.then_some(number))
}
