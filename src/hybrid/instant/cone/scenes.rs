//! Problems for the tests: bodies that touch, at random and built.

use crate::instant::cone::problem::{Law, Problem};
use nalgebra::{DMatrix, DVector, Vector3};

/// Random numbers that are the same on every machine.
pub struct Random(u64);

impl Random {
    /// A generator with a seed.
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(2).wrapping_add(1))
    }

    /// Between −1 and 1.
    pub fn signed(&mut self) -> f64 {
        self.between(-1.0, 1.0)
    }

    /// Between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A whole number below a bound.
    pub fn below(&mut self, bound: usize) -> usize {
        (self.between(0.0, bound as f64) as usize).min(bound - 1)
    }

    /// A direction.
    pub fn direction(&mut self) -> Vector3<f64> {
        loop {
            let vector = Vector3::from_fn(|_, _| self.signed());
            if (0.1..1.0).contains(&vector.norm()) {
                return vector.normalize();
            }
        }
    }
}

/// A free body.
pub struct Body {
    pub mass: f64,
    /// About the centre, along the axes of the world.
    pub inertia: Vector3<f64>,
    pub center: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub spin: Vector3<f64>,
}

impl Body {
    /// A box of these sides and mass at rest.
    pub fn cuboid(mass: f64, sides: [f64; 3], center: Vector3<f64>) -> Self {
        let [x, y, z] = sides.map(|side| side * side / 12.0 * mass);
        let zero = Vector3::zeros();
        Body { mass, inertia: Vector3::new(y + z, x + z, x + y), center, velocity: zero, spin: zero }
    }
}

/// A scene: bodies and rows between them.
pub struct Scene {
    pub bodies: Vec<Body>,
    pub laws: Vec<Law>,
    rows: Vec<DVector<f64>>,
    pub mobility: DMatrix<f64>,
    pub free: Vec<f64>,
}

impl Scene {
    /// A scene of bodies.
    pub fn new(bodies: Vec<Body>) -> Self {
        Scene { bodies, laws: Vec::new(), rows: Vec::new(), mobility: DMatrix::zeros(0, 0), free: Vec::new() }
    }

    /// A row: the velocity of a point of a body along a direction, less the velocity of the other body there (`None`: the world).
    pub fn row(&self, a: usize, b: Option<usize>, point: Vector3<f64>, along: Vector3<f64>) -> DVector<f64> {
        let mut row = DVector::zeros(6 * self.bodies.len());
        for (body, sign) in [(Some(a), 1.0), (b, -1.0)] {
            let Some(body) = body else { continue };
            let moment = (point - self.bodies[body].center).cross(&along);
            for axis in 0..3 {
                row[6 * body + axis] = sign * along[axis];
                row[6 * body + 3 + axis] = sign * moment[axis];
            }
        }
        row
    }

    /// Adds a contact with a normal from b to a.
    pub fn touch(&mut self, a: usize, b: Option<usize>, point: Vector3<f64>, normal: Vector3<f64>, law: Law) {
        let aside = if normal.x.abs() < 0.8 { Vector3::x() } else { Vector3::y() };
        let first = normal.cross(&aside).normalize();
        for along in [normal, first, normal.cross(&first)] {
            let row = self.row(a, b, point, along);
            self.rows.push(row);
        }
        self.laws.push(law);
    }

    /// Adds a row of its own.
    pub fn hold(&mut self, row: DVector<f64>, law: Law) {
        self.rows.push(row);
        self.laws.push(law);
    }

    /// D = W H⁻¹ Wᵀ and b = W v, after gravity has acted for a time.
    pub fn build(mut self, gravity: f64) -> Self {
        let count = self.rows.len();
        let mut inverse = DVector::zeros(6 * self.bodies.len());
        let mut velocity = DVector::zeros(6 * self.bodies.len());
        for (index, body) in self.bodies.iter().enumerate() {
            for axis in 0..3 {
                inverse[6 * index + axis] = 1.0 / body.mass;
                inverse[6 * index + 3 + axis] = 1.0 / body.inertia[axis];
                velocity[6 * index + axis] = body.velocity[axis];
                velocity[6 * index + 3 + axis] = body.spin[axis];
            }
            velocity[6 * index + 2] -= gravity;
        }
        let product = |row: usize, column: usize| {
            let (row, column) = (&self.rows[row.min(column)], &self.rows[row.max(column)]);
            row.iter().zip(column.iter()).zip(inverse.iter()).map(|((one, other), inverse)| one * other * inverse).sum()
        };
        self.mobility = DMatrix::from_fn(count, count, product);
        self.free = self.rows.iter().map(|row| row.dot(&velocity)).collect();
        self
    }

    /// The problem.
    pub fn problem(&self) -> Problem<'_> {
        Problem { mobility: &self.mobility, free: &self.free, laws: &self.laws }
    }
}

/// Bodies with masses over some decades that touch each other and the world at random.
pub fn random(contacts: usize, bodies: usize, decades: f64, friction: (f64, f64), seed: u64) -> Scene {
    let random = &mut Random::new(seed);
    let bodies = (0..bodies).map(|_| {
        let mass = 10.0_f64.powf(random.between(0.0, decades) - decades / 2.0);
        let radius = random.between(0.1, 0.5);
        Body {
            mass,
            inertia: Vector3::from_fn(|_, _| random.between(0.3, 0.5)) * (mass * radius * radius),
            center: Vector3::from_fn(|_, _| random.signed()),
            velocity: Vector3::from_fn(|_, _| random.signed()),
            spin: Vector3::from_fn(|_, _| random.signed()),
        }
    });
    let mut scene = Scene::new(bodies.collect());
    for _ in 0..contacts {
        let a = random.below(scene.bodies.len());
        let b = Some(random.below(scene.bodies.len() + 1)).filter(|&b| b < scene.bodies.len() && b != a);
        let point = scene.bodies[a].center + random.direction() * 0.4;
        let law = Law::Contact { friction: random.between(friction.0, friction.1) };
        scene.touch(a, b, point, random.direction(), law);
    }
    scene.build(0.0)
}

/// Boxes of side 1 on each other and on the ground, on four corners each, after gravity has acted for a time.
pub fn stack(masses: &[f64], friction: f64, gravity: f64) -> Scene {
    let bodies = masses.iter().enumerate();
    let bodies = bodies.map(|(level, &mass)| Body::cuboid(mass, [1.0; 3], Vector3::new(0.0, 0.0, level as f64 + 0.5)));
    let mut scene = Scene::new(bodies.collect());
    for level in 0..masses.len() {
        for (x, y) in [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)] {
            let point = Vector3::new(x, y, level as f64);
            scene.touch(level, level.checked_sub(1), point, Vector3::z(), Law::Contact { friction });
        }
    }
    scene.build(gravity)
}

/// An arch of blocks between two abutments, on four points at each joint.
pub fn arch(blocks: usize, thickness: f64, friction: f64, gravity: f64) -> Scene {
    let angle = |joint: usize| std::f64::consts::PI * (1.0 - joint as f64 / blocks as f64);
    let radial = |angle: f64| Vector3::new(angle.cos(), 0.0, angle.sin());
    let sides = [std::f64::consts::PI / blocks as f64, 0.3, thickness];
    let bodies = (0..blocks).map(|block| {
        let middle = 0.5 * (angle(block) + angle(block + 1));
        Body::cuboid(sides[0] * sides[1] * thickness, sides, radial(middle))
    });
    let mut scene = Scene::new(bodies.collect());
    for joint in 0..=blocks {
        let at = angle(joint);
        // The normal points from the left block to the right one.
        let along = Vector3::new(at.sin(), 0.0, -at.cos());
        for (radius, y) in [(-0.5, -0.15), (-0.5, 0.15), (0.5, -0.15), (0.5, 0.15)] {
            let point = radial(at) * (1.0 + radius * thickness) + Vector3::new(0.0, y, 0.0);
            let law = Law::Contact { friction };
            match joint {
                0 => scene.touch(0, None, point, along, law),
                last if last == blocks => scene.touch(blocks - 1, None, point, -along, law),
                _ => scene.touch(joint, Some(joint - 1), point, along, law),
            }
        }
    }
    scene.build(gravity)
}

/// A box pushed down between two inclined planes, on four corners at each of them; angle from the vertical.
pub fn wedge(angle: f64, friction: f64, gravity: f64) -> Scene {
    let mut scene = Scene::new(vec![Body::cuboid(1.0, [1.0; 3], Vector3::new(0.0, 0.0, 0.5))]);
    for side in [-1.0, 1.0] {
        let normal = Vector3::new(-side * angle.cos(), 0.0, angle.sin());
        for (y, z) in [(-0.5, 0.0), (-0.5, 1.0), (0.5, 0.0), (0.5, 1.0)] {
            scene.touch(0, None, Vector3::new(side * 0.5, y, z), normal, Law::Contact { friction });
        }
    }
    scene.build(gravity)
}

/// A chain of rods on ball joints that lands on the ground with speed 1, each rod on two points.
pub fn chain(rods: usize, tip_mass: f64, friction: f64) -> Scene {
    let bodies = (0..rods).map(|rod| {
        let mass = if rod + 1 == rods { tip_mass } else { 1.0 };
        let mut body = Body::cuboid(mass, [1.0, 0.1, 0.1], Vector3::new(rod as f64 + 0.5, 0.0, 0.05));
        body.velocity = Vector3::new(0.3, 0.1 * (rod as f64).sin(), -1.0);
        body
    });
    let mut scene = Scene::new(bodies.collect());
    for rod in 1..rods {
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let row = scene.row(rod, Some(rod - 1), Vector3::new(rod as f64, 0.0, 0.05), axis);
            scene.hold(row, Law::Interval { lower: f64::NEG_INFINITY, upper: f64::INFINITY });
        }
    }
    for rod in 0..rods {
        for x in [0.1, 0.9] {
            let point = Vector3::new(rod as f64 + x, 0.03 * (3.0 * rod as f64 + x).sin(), 0.0);
            scene.touch(rod, None, point, Vector3::z(), Law::Contact { friction });
        }
    }
    scene.build(0.0)
}
