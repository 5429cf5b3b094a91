//! The equations that are written out, against the same by numbers with derivatives: the oracle of this room.

use crate::derivatives::equations::closures::closures;
use crate::derivatives::equations::placed::{Offsets, place};
use crate::derivatives::forward::elimination::Elimination;
use crate::derivatives::forward::stage_equations::BothFigures;
use crate::derivatives::forward::step::{Factors, Part, SolvedStep, StepMode, StepProblem};
use crate::derivatives::forward::tangent::{InputSlopes, Tangent, Varied};
use crate::derivatives::forward::tree::adjoint::FigureCotangents;
use crate::derivatives::forward::tree::carrying::TreeColumns;
use crate::derivatives::forward::tree::column::Column;
use crate::derivatives::forward::tree::family::Family;
use crate::derivatives::forward::tree::matrix::TreeMatrix;
use crate::derivatives::forward::tree::over_step::by_length;
use crate::derivatives::forward::tree::step::{TreeStep, efforts};
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;
use crate::instant::holding::elements::Elements;
use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use crate::model::{Base, Model, ModelOptions};
use crate::scene::{PackagePath, read_scene, read_urdf};
use nalgebra::{DMatrix, DVector};
use std::path::{Path, PathBuf};

/// Both take the same sums in another order: roundings of some hundred terms.
const ROUNDINGS: f64 = 1e-12;

fn robots(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(file)
}

fn urdf(file: &str, base: Base) -> Mechanism {
    let robot = read_urdf(&robots(file), &PackagePath::default()).expect("a robot");
    Model::new(robot, &ModelOptions { base, ..ModelOptions::default() }).expect("a model").mechanism
}

fn scene(file: &str) -> Mechanism {
    let scene = read_scene(&robots(file), &PackagePath::default()).expect("a scene");
    Model::from_scene(&scene).expect("a model").0.mechanism
}

/// Trees with turning, sliding, ball, planar and floating joints, springs, dampers and motors.
fn trees() -> Vec<Mechanism> {
    vec![
        urdf("arm7.urdf", Base::Fixed),
        urdf("humanoid.urdf", Base::Floating),
        urdf("spherical_chain.urdf", Base::Fixed),
        urdf("planar_slider.urdf", Base::Fixed),
        urdf("gantry.urdf", Base::Fixed),
        scene("damped_oscillator.toml"),
        scene("cart_pole_light.toml"),
        scene("arm7_held.toml"),
    ]
}

/// Numbers in (−1, 1) that look random.
fn number(seed: usize) -> f64 {
    let mixed = (seed as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// The number of all closures.
fn closure_count(case: &Case) -> usize {
    let still = vec![0.0; case.mechanism.velocity_count];
    let start = &case.start;
    let at = Offsets { from: start, to: start, first: &still, second: &still, motion: &[] };
    closures(&case.figures.plain, &[], &place(&case.figures.plain, &at), &at).len()
}

/// A tree in motion with a step to be solved.
struct Case {
    mechanism: Mechanism,
    elements: Elements,
    frames: Vec<Pose>,
    figures: BothFigures<f64>,
    constant: BothFigures<Part>,
    mode: StepMode,
    start: State,
    efforts: Vec<DVector<f64>>,
    tableau: &'static Tableau,
}

impl Case {
    /// With some joints held, if there are many.
    fn new(mut mechanism: Mechanism, stages: usize) -> Self {
        // Closed contacts and limits are no part of a step of a tree.
        mechanism.nonsmooth.pairs.clear();
        let n = mechanism.velocity_count;
        let elements = Elements::new(&mechanism);
        let frames = vec![Pose::identity(); mechanism.bodies.len()];
        let held = |body: usize| n > 6 && body == 2;
        let bodies = mechanism.bodies.iter().enumerate().filter(|(body, _)| !held(*body));
        let free: Vec<usize> = bodies.flat_map(|(_, body)| body.joint.velocity_range()).collect();
        let motors = elements.motors.iter().enumerate().map(|(index, motor)| (index, motor.coordinate)).collect();
        let mut start = State::zero(&mechanism);
        let moved: Vec<f64> = (0..n).map(|freedom| 0.7 * number(freedom)).collect();
        start.displace(&mechanism, &moved);
        start.velocity =
            (0..n).map(|freedom| if free.contains(&freedom) { number(100 + freedom) } else { 0.0 }).collect();
        let effort = |stage: usize| DVector::from_fn(n, |row, _| number(1000 + stage * n + row));
        Case {
            figures: BothFigures::taken(&mechanism, &elements, &frames, |_, value| value),
            constant: BothFigures::taken(&mechanism, &elements, &frames, |_, value| Part::of(value)),
            mode: StepMode { free, motors, ..StepMode::default() },
            efforts: (0..stages).map(effort).collect(),
            tableau: Tableau::of(stages).expect("stages"),
            mechanism,
            elements,
            frames,
            start,
        }
    }

    fn problem(&self) -> StepProblem<'_> {
        StepProblem {
            mechanism: &self.mechanism,
            figures: &self.figures,
            constant: &self.constant,
            tableau: self.tableau,
            mode: &self.mode,
            start: &self.start,
            step: 0.02,
            begun: &self.start,
            toward: &self.start,
            inside: &[],
            efforts: &self.efforts,
        }
    }

    /// Stages and velocities that solve nothing.
    fn stages(&self) -> (Vec<State>, Vec<f64>) {
        let n = self.mechanism.velocity_count;
        let free = |freedom: usize| self.mode.free.contains(&freedom);
        let stage = |index: usize| {
            let mut stage = self.start.clone();
            let by: Vec<f64> =
                (0..n).map(|row| if free(row) { 0.05 * number(7000 + index * n + row) } else { 0.0 }).collect();
            stage.displace(&self.mechanism, &by);
            stage
        };
        let velocities = (0..n).map(|row| if free(row) { number(9000 + row) } else { 0.0 }).collect();
        ((1..self.tableau.stages).map(stage).collect(), velocities)
    }
}

/// The same slopes of figures with symmetric second moments and frames that stay frames. The list has three numbers of gravity, and for each body
/// mass, p, P, and two frames with their axes and origins.
fn rigid(case: &Case, mut slopes: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    for (column, slopes) in slopes.iter_mut().enumerate() {
        for (index, body) in case.figures.plain.bodies.iter().enumerate() {
            let first = 3 + 37 * index;
            let second: Vec<f64> = slopes[first + 4..first + 13].to_vec();
            for (entry, place) in (0..9).map(|entry| (entry, first + 4 + entry)) {
                slopes[place] = 0.5 * (second[entry] + second[3 * (entry % 3) + entry / 3]);
            }
            for (which, frame) in [&body.on_parent, &body.on_child].into_iter().enumerate() {
                let varies = (index + which) % 5 == column % 5;
                let turn = [0, 1, 2].map(|axis| if varies { number(500 + 10 * index + 3 * which + axis) } else { 0.0 });
                for (axis, own) in frame.axes.0.iter().enumerate() {
                    let change = Vector(turn).cross(*own);
                    let place = first + 13 + 12 * which + 3 * axis;
                    slopes[place..place + 3].copy_from_slice(&change.0);
                }
            }
        }
    }
    slopes
}

fn assert_near(name: &str, own: &DMatrix<f64>, other: &DMatrix<f64>, bound: f64) {
    let apart = (own - other).amax() / other.amax().max(1e-30);
    assert!(apart < bound, "{name}: apart by {apart:.1e}\n{:.3e}\n{:.3e}", own, other);
}

#[test]
fn equations_of_trees_that_are_written_out_and_their_matrices_are_those_of_numbers_with_derivatives() {
    for mechanism in trees() {
        for stages in [2, 5] {
            let case = Case::new(mechanism.clone(), stages);
            let (at, velocities) = case.stages();
            let problem = case.problem();
            assert!(problem.is_tree(), "{}", case.mechanism.name);
            let family = Family::new(&case.figures.plain, &case.mode.free);
            let step = TreeStep::new(&problem, &family, &at, &velocities);
            let column = |of: DVector<f64>| DMatrix::from_column_slice(of.len(), 1, of.as_slice());
            let multipliers = vec![Vec::new(); stages];
            let own = column(step.residual(&efforts(&step)));
            assert_near(
                &case.mechanism.name,
                &own,
                &column(problem.residual(&at, &velocities, &multipliers)),
                ROUNDINGS,
            );
            let matrix = problem.matrix(&at, &velocities, &multipliers);
            let mut whole = DMatrix::zeros(matrix.nrows(), matrix.ncols());
            TreeMatrix::new(&step).copy_to(&mut whole);
            assert_near(&case.mechanism.name, &whole, &matrix, ROUNDINGS);
        }
    }
}

#[test]
fn matrices_of_trees_with_closures_from_blocks_are_those_of_numbers_with_derivatives() {
    for file in ["four_bar_1.toml", "four_bar_2.toml", "slider_crank.toml"] {
        for stages in [2, 5] {
            let mut case = Case::new(scene(file), stages);
            case.mode.row_count = closure_count(&case);
            case.mode.rows = (0..case.mode.row_count).filter(|row| row % 5 != 3).collect();
            let (at, velocities) = case.stages();
            let problem = case.problem();
            assert!(problem.is_looped() && !problem.is_tree(), "{file}");
            let count = case.mode.row_count;
            let multipliers: Vec<Vec<f64>> =
                (0..stages).map(|stage| (0..count).map(|row| number(4000 + stage * count + row)).collect()).collect();
            let matrix = problem.matrix(&at, &velocities, &multipliers);
            assert_near(file, &problem.looped_matrix(&at, &velocities, &multipliers), &matrix, ROUNDINGS);
            let (n, m) = (case.mode.free.len(), case.mode.rows.len());
            let columns = matrix.view((0, stages * n), (stages * n, stages * m)).into_owned();
            assert_near(file, &problem.push_columns(&at), &columns, ROUNDINGS);
        }
    }
}

#[test]
fn derivatives_over_a_step_of_a_tree_are_those_of_numbers_with_derivatives() {
    for mechanism in trees() {
        let case = Case::new(mechanism, 4);
        let problem = case.problem();
        let n = case.mechanism.velocity_count;
        let solved = problem.solve(None).expect("a step");
        let end = solved.stages.last().expect("an end").clone();
        let multipliers = vec![Vec::new(); 4];
        let left = problem.residual(&solved.stages, &end.velocity, &multipliers).amax();
        // Roundings of places of some metres, times the mass and coefficients of some tens.
        let mass: f64 = case.mechanism.bodies.iter().map(|body| body.mass).sum();
        assert!(left < 1e-13 * mass.max(1.0), "{}: {left:.1e} and {mass} kg", case.mechanism.name);
        let whole = Elimination::new(&problem.matrix(&solved.stages, &end.velocity, &multipliers)).expect("factors");
        let (stages, factors) = (solved.stages.clone(), Factors::Whole(whole));
        let literal = SolvedStep { stages, multipliers, factors, drift: 0.0 };
        // One parameter for each kind of number, and one that changes all of them, the start and the length.
        let count = std::cell::Cell::new(0);
        let _ = BothFigures::taken(&case.mechanism, &case.elements, &case.frames, |entry, value| {
            count.set(count.get().max(entry + 1));
            value
        });
        let count = count.get();
        let columns = 11;
        let slopes: Vec<Vec<f64>> = (0..columns)
            .map(|column| {
                (0..count)
                    .map(|entry| if entry % columns == column { number(entry + 31 * column) } else { 0.0 })
                    .collect()
            })
            .collect();
        let varied = Varied::new(&case.mechanism, &case.elements, &case.frames, &rigid(&case, slopes));
        let matrix = |seed: usize, of: &dyn Fn(usize) -> bool| {
            DMatrix::from_fn(
                n,
                columns,
                |row, column| if of(column) { number(seed + row * columns + column) } else { 0.0 },
            )
        };
        let mut tangent = Tangent {
            positions: matrix(1, &|column| column % 2 == 0),
            velocities: matrix(2, &|column| column % 3 == 0),
            times: DVector::from_fn(columns, |row, _| number(row)),
        };
        // Held joints have no velocity.
        for freedom in (0..n).filter(|freedom| !case.mode.free.contains(freedom)) {
            tangent.velocities.row_mut(freedom).fill(0.0);
        }
        let slopes: Vec<DMatrix<f64>> = (0..4).map(|stage| matrix(40 + stage, &|column| column == 3)).collect();
        let rates: Vec<DVector<f64>> =
            (0..4).map(|stage| DVector::from_fn(n, |row, _| number(60 + stage * n + row))).collect();
        let closed = vec![Default::default(); varied.chunks().len()];
        let inputs = InputSlopes { efforts: &slopes, rates: &rates, closed: &closed };
        let longer = DVector::from_fn(columns, |row, _| if row % 4 == 0 { number(200 + row) } else { 0.0 });
        let carry = |solved: &SolvedStep| {
            let mut own = tangent.clone();
            own.carry(&problem, solved, &varied, &inputs, &longer).expect("derivatives");
            own
        };
        let (own, other) = (carry(&solved), carry(&literal));
        assert_near(&case.mechanism.name, &own.positions, &other.positions, ROUNDINGS);
        assert_near(&case.mechanism.name, &own.velocities, &other.velocities, ROUNDINGS);
        let Factors::Tree(factors) = &solved.factors else { panic!("{} is a tree", case.mechanism.name) };
        let all = TreeColumns { tangent: &tangent, longer: &longer, efforts: &slopes, rates: &rates };
        let columns = all.by_columns(&problem, &solved, factors, varied.slopes()).expect("columns");
        let rows = all.by_rows(&problem, &solved, factors, varied.slopes()).expect("rows");
        for (own, other) in rows.iter().zip(&columns) {
            assert_near(&case.mechanism.name, own, other, ROUNDINGS);
        }
        let of_length = |solved: &SolvedStep| {
            let (positions, velocities) = by_length(&problem, solved, &rates).expect("derivatives");
            DMatrix::from_columns(&[positions, velocities])
        };
        assert_near(&case.mechanism.name, &of_length(&solved), &of_length(&literal), ROUNDINGS);
    }
}

#[test]
fn a_step_that_begins_at_its_stages_with_other_velocities_at_its_end_has_the_same_derivatives() {
    for mechanism in trees() {
        let case = Case::new(mechanism, 4);
        let solved = case.problem().solve(None).expect("a step");
        let end = solved.stages.last().expect("an end");
        let mut toward = end.clone();
        case.mode.free.iter().for_each(|&freedom| toward.velocity[freedom] += number(300 + freedom));
        let problem = StepProblem { toward: &toward, inside: &solved.stages[..2], ..case.problem() };
        let again = problem.solve(None).expect("the same step");
        let rates = vec![DVector::zeros(case.mechanism.velocity_count); 4];
        let of_length = |solved: &SolvedStep| {
            let (positions, velocities) = by_length(&problem, solved, &rates).expect("derivatives");
            let of_end = DVector::from_column_slice(&solved.stages[2].velocity);
            DMatrix::from_columns(&[positions, velocities, of_end])
        };
        // Stages with other roundings, times a condition of some thousands where slender links turn about themselves. The matrix of the other
        // velocities makes a tenth.
        assert_near(&case.mechanism.name, &of_length(&again), &of_length(&solved), 1e-10);
    }
}

#[test]
fn the_transpose_of_a_step_has_the_same_products_as_its_columns() {
    for mechanism in trees() {
        let case = Case::new(mechanism, 4);
        let problem = case.problem();
        let n = case.mechanism.velocity_count;
        let solved = problem.solve(None).expect("a step");
        let Factors::Tree(factors) = &solved.factors else { panic!("{} is a tree", case.mechanism.name) };
        let family = Family::new(&case.figures.plain, &case.mode.free);
        let end = solved.stages.last().expect("an end");
        let step = TreeStep::new(&problem, &family, &solved.stages, &end.velocity);
        let all = efforts(&step);
        let count = case.figures.plain.bodies.len();
        let numbers = 3 + 37 * count + 200;
        let slopes: Vec<f64> = (0..numbers).map(|entry| number(entry + 77)).collect();
        let slopes = rigid(&case, vec![slopes]);
        let varied = Varied::new(&case.mechanism, &case.elements, &case.frames, &slopes);
        let figures = varied.slopes()[0].as_ref().expect("figures that change");
        let (positions, velocities): (Vec<f64>, Vec<f64>) =
            (0..n).map(|row| (number(row + 3), number(row + 9))).unzip();
        let longer = 0.7;
        let of_effort = |stage: usize, freedom: usize| number(stage * n + freedom + 11);
        let column = Column {
            positions: &positions,
            velocities: &velocities,
            longer,
            efforts: &of_effort,
            figures: Some(figures),
        };
        let right = step.right(&all, &[column]);
        let free = case.mode.free.len();
        let [left, other] = [20, 21].map(|seed| DVector::from_fn(free, |row, _| number(row * 13 + seed)));
        let weights = factors.solve_transposed(&left, &other);
        let found = factors.solve(&right);
        let forward =
            found.column(0).rows(2 * free, free).dot(&left) + found.column(0).rows(3 * free, free).dot(&other);
        let mut constant = FigureCotangents::zero(count, varied.slopes());
        let pulled = step.pull_back(&step.courses(), &all, &weights, &mut constant);
        let sum = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(one, other)| one * other).sum::<f64>();
        let of_efforts: f64 = pulled
            .efforts
            .iter()
            .enumerate()
            .map(|(stage, own)| own.iter().enumerate().map(|(freedom, by)| by * of_effort(stage, freedom)).sum::<f64>())
            .sum();
        let parts = [
            sum(&pulled.positions, &positions),
            sum(&pulled.velocities, &velocities),
            pulled.longer * longer,
            of_efforts,
            constant.by(figures),
            -weights.dot(&step.law_changes(figures)),
        ];
        let backward: f64 = parts.iter().sum();
        // The parts cancel; each has roundings of its own.
        let size = parts.iter().fold(forward.abs(), |size, part| size.max(part.abs()));
        let apart = (forward - backward).abs() / size;
        assert!(apart < ROUNDINGS, "{}: {forward} and {backward}, {parts:?}", case.mechanism.name);
    }
}
