//! The scenes of the simulation benchmarks: bodies, joints, what drives them and how they look.

use forcec_constraints::cloth::{dihedral, stvk_triangle};
use forcec_constraints::joints::point_to_point;
use forcec_constraints::solids::stable_neo_hookean;
use forcec_runtime::nalgebra::{Matrix2, Matrix3};
use forcec_runtime::prelude::{Particle, Rigid, Vec3};
use forcec_runtime::{Body, Motion, World, Wrench};
use std::collections::BTreeMap;

/// Gravity, m/s².
pub const GRAVITY: f64 = 9.81;

/// A world and what there is to know of it.
pub struct Scene {
    /// Bodies and forces.
    pub world: World,
    /// Its bodies that forces move, in order.
    pub bodies: Vec<Body>,
    /// Their masses, kg.
    pub masses: Vec<f64>,
    /// Half the sides of a rigid body's box, m, for each of these; empty for particles.
    pub boxes: Vec<[f64; 3]>,
    /// Pairs of particles between which a line is drawn.
    pub edges: Vec<(Body, Body)>,
    /// What changes from step to step: called with the time in the middle of it.
    pub drive: Option<Drive>,
    /// How long it lasts, s.
    pub time: f64,
    /// Its usual step, s.
    pub step: f64,
}

/// Sets the loads of a world for a time.
pub type Drive = Box<dyn Fn(&mut World, f64)>;

impl Scene {
    /// Nothing but gravity.
    pub fn new(time: f64, step: f64) -> Scene {
        let mut world = World::default();
        world.gravity = Vec3::new(0.0, 0.0, -GRAVITY);
        Scene {
            world,
            bodies: Vec::new(),
            masses: Vec::new(),
            boxes: Vec::new(),
            edges: Vec::new(),
            drive: None,
            time,
            step,
        }
    }

    /// Moves on by a step at a time.
    pub fn advance(&mut self, time: f64, h: f64) -> forcec_runtime::Report {
        if let Some(drive) = &self.drive {
            drive(&mut self.world, time + 0.5 * h);
        }
        self.world.step(h).expect("a step that is positive and finite")
    }

    /// Where its bodies are, m.
    pub fn positions(&self) -> Vec<Vec3> {
        self.bodies.iter().map(|&body| self.world.position(body).expect("a body of the scene")).collect()
    }

    /// Potential energy in gravity, zero at height zero, J.
    pub fn potential(&self) -> f64 {
        let heights = self.positions().into_iter().zip(&self.masses);
        heights.map(|(position, mass)| -mass * self.world.gravity.dot(&position)).sum()
    }

    /// Adds a rigid body with half the sides of its box, m.
    pub fn rigid(&mut self, state: Rigid, mass: f64, inertia: Vec3, half: [f64; 3]) -> Body {
        let body = self.world.add_rigid(state, Motion::Dynamic(mass, inertia)).expect("a sound body");
        self.bodies.push(body);
        self.masses.push(mass);
        self.boxes.push(half);
        body
    }

    fn particle(&mut self, position: Vec3, motion: Motion<f64>) -> Body {
        let state = Particle { position, ..Particle::default() };
        let body = self.world.add_particle(state, motion).expect("a sound particle");
        if let Motion::Dynamic(mass, _) = motion {
            self.bodies.push(body);
            self.masses.push(mass);
        }
        body
    }
}

/// Makes a scene.
pub type Make = fn() -> Scene;

/// The scenes by name, and what they are.
pub const SCENES: [(&str, &str, Make); 6] = [
    ("c10", "ten rods end to end, pinned, turning about the pin", || c10(1e6)),
    ("ben25", "25 articulated robots, hanging, driven by torques", || ben25(1e7, true)),
    ("ben25-free", "the same, turning freely about their pins", || ben25(1e7, false)),
    ("t-handle", "a free body that spins about its middle axis", t_handle),
    ("cloth", "a cloth of 40 × 40 particles, held at two corners", || cloth(40)),
    ("bar", "a bar of 20 × 4 × 4 cells of tetrahedra, held at one end", || bar([20, 4, 4])),
];

/// The rods of [`Chain`]: 0.5 × 0.1 × 0.06 m and 1 kg.
pub const ROD: [f64; 3] = [0.25, 0.05, 0.03];

/// Moments of a box of such half sides, kg·m².
pub fn box_inertia(mass: f64, half: [f64; 3]) -> Vec3 {
    let [x, y, z] = half.map(|half| half * half * mass / 3.0);
    Vec3::new(y + z, x + z, x + y)
}

/// A chain of rods, to be varied.
#[derive(Clone, Copy, Debug)]
pub struct Chain {
    /// How many rods.
    pub rods: usize,
    /// Of every joint, N/m.
    pub stiffness: f64,
    /// In units of critical damping.
    pub damping: f64,
    /// Of rod k out of n, kg; its inertia goes along.
    pub mass: fn(usize, usize) -> f64,
    /// Moments of a rod of 1 kg, kg·m².
    pub inertia: [f64; 3],
    /// The pin, m.
    pub origin: [f64; 3],
    /// How far each joint is torn open at the start, m.
    pub stretch: f64,
    /// Whether the first rod is pinned to the world.
    pub pinned: bool,
}

impl Default for Chain {
    fn default() -> Chain {
        Chain {
            rods: 10,
            stiffness: 1e6,
            damping: 1.0,
            mass: |_, _| 1.0,
            inertia: box_inertia(1.0, ROD).into(),
            origin: [0.0; 3],
            stretch: 0.0,
            pinned: true,
        }
    }
}

impl Chain {
    /// The rods end to end along x, turning at (3, 0, 0.5) about the pin as one rigid piece.
    pub fn scene(self) -> Scene {
        let mut scene = Scene::new(0.5, 1.0 / 120.0);
        let spin = Vec3::new(3.0, 0.0, 0.5);
        let origin = Vec3::from(self.origin);
        let pin = scene
            .world
            .add_rigid(Rigid { position: origin, ..Rigid::default() }, Motion::Kinematic)
            .expect("a pin");
        let mut before = (pin, 0.0, f64::INFINITY, [f64::INFINITY; 3]);
        for k in 0..self.rods {
            let arm = Vec3::new((0.5 + self.stretch) * k as f64 + 0.25 + self.stretch, 0.0, 0.0);
            let mass = (self.mass)(k, self.rods);
            let inertia = self.inertia.map(|moment| moment * mass);
            let state = Rigid {
                position: origin + arm,
                velocity: spin.cross(&arm),
                angular_velocity: spin,
                ..Rigid::default()
            };
            let body = scene.rigid(state, mass, inertia.into(), ROD);
            let (other, arm_a, other_mass, other_inertia) = before;
            if k > 0 || self.pinned {
                let mobility =
                    1.0 / mass + 0.0625 / inertia[2] + 1.0 / other_mass + 0.0625 / other_inertia[2];
                let damping = self.damping * 2.0 * (self.stiffness / mobility).sqrt();
                let params = point_to_point::Params {
                    arm_a: [arm_a, 0.0, 0.0],
                    arm_b: [-0.25, 0.0, 0.0],
                    stiffness: self.stiffness,
                    damping,
                };
                scene.world.add(params, [other, body]).expect("a joint");
            }
            before = (body, 0.25, mass, inertia);
        }
        scene
    }
}

/// The chain of the catalogue.
pub fn c10(stiffness: f64) -> Scene {
    Chain { stiffness, ..Chain::default() }.scene()
}

/// A body of a robot.
#[derive(Clone, Copy, Debug)]
struct Link {
    parent: Option<usize>,
    mass: f64,
    inertia: [f64; 3],
    centre: Vec3,
    joint: Vec3,
}

/// The robot `ben`, a row a body.
fn ben() -> Vec<Link> {
    let text = include_str!("../scenes/ben.csv");
    let rows = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit() || c == '-'));
    let link = |row: &str| {
        let numbers: Vec<f64> = row.split(',').map(|x| x.parse().expect("a number")).collect();
        let at = |k: usize| [numbers[k], numbers[k + 1], numbers[k + 2]];
        let parent = (numbers[0] >= 0.0).then_some(numbers[0] as usize);
        Link { parent, mass: numbers[1], inertia: at(2), centre: at(5).into(), joint: at(8).into() }
    };
    rows.map(link).collect()
}

/// 25 robots 3 m apart, head pinned, hanging; driven by torques, or turning about the pin as one rigid piece.
pub fn ben25(stiffness: f64, driven: bool) -> Scene {
    robots(25, stiffness, driven)
}

/// Some robots, as in [`ben25`].
pub fn robots(count: usize, stiffness: f64, driven: bool) -> Scene {
    let links = ben();
    let mut scene = Scene::new(if driven { 1.0 } else { 10.0 }, 1.0 / 60.0);
    let spin = if driven { Vec3::zeros() } else { Vec3::new(2.0, 1.0, 0.0) };
    for robot in 0..count {
        let at = Vec3::new(3.0 * (robot % 5) as f64, 3.0 * (robot / 5) as f64, 0.0);
        let pin = Rigid { position: at, ..Rigid::default() };
        let pin = scene.world.add_rigid(pin, Motion::Kinematic).expect("a pin");
        let first = scene.bodies.len();
        for link in &links {
            let state = Rigid {
                position: at + link.centre,
                velocity: spin.cross(&link.centre),
                angular_velocity: spin,
                ..Rigid::default()
            };
            // The box that has these moments.
            let [x, y, z] = link.inertia.map(|moment| 1.5 * moment / link.mass);
            let half = [y + z - x, x + z - y, x + y - z].map(|square| square.max(1e-4).sqrt());
            let body = scene.rigid(state, link.mass, link.inertia.into(), half);
            let arm_b = link.joint - link.centre;
            let mut mobility = 1.0 / link.mass + arm_b.norm_squared() / link.inertia[0];
            let (other, arm_a) = match link.parent {
                Some(parent) => {
                    let other = links[parent];
                    let arm = link.joint - other.centre;
                    mobility += 1.0 / other.mass + arm.norm_squared() / other.inertia[0];
                    (scene.bodies[first + parent], arm)
                }
                None => (pin, link.joint),
            };
            let damping = 2.0 * (stiffness / mobility).sqrt();
            let params =
                point_to_point::Params { arm_a: arm_a.into(), arm_b: arm_b.into(), stiffness, damping };
            scene.world.add(params, [other, body]).expect("a joint");
        }
    }
    if driven {
        let bodies = scene.bodies.clone();
        scene.drive = Some(Box::new(move |world, time| {
            for robot in bodies.chunks_exact(links.len()) {
                let mut torques = vec![Vec3::zeros(); links.len()];
                for (k, link) in links.iter().enumerate() {
                    let Some(parent) = link.parent else { continue };
                    let turn = std::f64::consts::TAU * (0.5 + 0.05 * k as f64) * time + k as f64;
                    let axis = if k % 2 == 0 { Vec3::x() } else { Vec3::y() };
                    let torque = axis * (0.3 * link.mass * GRAVITY * 0.15 * turn.sin());
                    torques[k] += torque;
                    torques[parent] -= torque;
                }
                for (&body, torque) in robot.iter().zip(torques) {
                    let load = Wrench { force: Vec3::zeros(), torque };
                    world.set_load(body, load).expect("a body of the robot");
                }
            }
        }));
    }
    scene
}

/// A free body with moments 1, 2, 3 that spins about its middle axis, which is unstable.
pub fn t_handle() -> Scene {
    let mut scene = Scene::new(20.0, 1.0 / 60.0);
    scene.world.gravity = Vec3::zeros();
    scene.world.settings.integrator = forcec_runtime::Integrator::Rodas4;
    // When it turns over hangs on the smallest of errors.
    scene.world.settings.tolerance = 1e-9;
    let state = Rigid { angular_velocity: Vec3::new(0.01, 10.0, 0.0), ..Rigid::default() };
    scene.rigid(state, 1.0, Vec3::new(1.0, 2.0, 3.0), [0.7, 0.5, 0.3]);
    scene
}

/// A square of cloth, 1 m wide and of 0.2 kg/m², in the plane and held at two corners.
pub fn cloth(side: usize) -> Scene {
    let mut scene = Scene::new(2.0, 1.0 / 60.0);
    let cell = 1.0 / (side - 1) as f64;
    let mass = 0.2 / (side * side) as f64;
    let mut grid = Vec::new();
    for row in 0..side {
        for column in 0..side {
            let held = row == 0 && (column == 0 || column + 1 == side);
            let motion = if held { Motion::Kinematic } else { Motion::Dynamic(mass, Vec3::zeros()) };
            grid.push(scene.particle(Vec3::new(column as f64 * cell, row as f64 * cell, 0.0), motion));
        }
    }
    let at = |row: usize, column: usize| grid[row * side + column];
    let rest = Matrix2::new(cell, 0.0, 0.0, cell).try_inverse().expect("edges that span a plane");
    let inverse_rest = [[rest[(0, 0)], rest[(0, 1)]], [rest[(1, 0)], rest[(1, 1)]]];
    let params = stvk_triangle::Params { inverse_rest, area: 0.5 * cell * cell, mu: 500.0, lambda: 200.0 };
    let mut opposite: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    let number = |row: usize, column: usize| row * side + column;
    for row in 0..side - 1 {
        for column in 0..side - 1 {
            let triangles = [
                [number(row, column), number(row, column + 1), number(row + 1, column)],
                [number(row + 1, column + 1), number(row + 1, column), number(row, column + 1)],
            ];
            for [a, b, c] in triangles {
                scene.world.add(params, [grid[a], grid[b], grid[c]]).expect("a triangle");
                for (i, j, k) in [(a, b, c), (b, c, a), (c, a, b)] {
                    opposite.entry((i.min(j), i.max(j))).or_default().push(k);
                }
            }
            scene.edges.push((at(row, column), at(row, column + 1)));
            scene.edges.push((at(row, column), at(row + 1, column)));
        }
    }
    for (&(i, j), ends) in &opposite {
        if let [k, l] = ends[..] {
            let bend = dihedral::Params { stiffness: 1e-4, rest_angle: 0.0 };
            let bodies = [grid[i], grid[j], grid[k], grid[l]];
            if scene.world.add(bend, bodies).is_err() {
                unreachable!("no pair of triangles has all corners held");
            }
        }
    }
    scene
}

/// A bar of cells of 5 cm, each of five tetrahedra, 1000 kg/m³, held at one end.
pub fn bar(cells: [usize; 3]) -> Scene {
    let mut scene = Scene::new(1.0, 1.0 / 60.0);
    let cell = 0.05;
    let number = |x: usize, y: usize, z: usize| (z * (cells[1] + 1) + y) * (cells[0] + 1) + x;
    let mut tetrahedra = tetrahedra(cells, &number);
    let count = number(cells[0], cells[1], cells[2]) + 1;
    let (mut masses, mut places) = (vec![0.0; count], vec![Vec3::zeros(); count]);
    for z in 0..=cells[2] {
        for y in 0..=cells[1] {
            for x in 0..=cells[0] {
                places[number(x, y, z)] = Vec3::new(x as f64, y as f64, z as f64) * cell;
            }
        }
    }
    let edges =
        |[a, b, c, d]: [usize; 4]| Matrix3::from_columns(&[b, c, d].map(|corner| places[corner] - places[a]));
    for corners in &mut tetrahedra {
        if edges(*corners).determinant() < 0.0 {
            corners.swap(2, 3);
        }
        let share = 1000.0 * edges(*corners).determinant() / 6.0 / 4.0;
        corners.iter().for_each(|&corner| masses[corner] += share);
    }
    let mut grid = Vec::new();
    for (place, mass) in places.iter().zip(masses) {
        let motion = if place.x == 0.0 { Motion::Kinematic } else { Motion::Dynamic(mass, Vec3::zeros()) };
        grid.push(scene.particle(*place, motion));
    }
    for corners in tetrahedra {
        let edges = edges(corners);
        let inverse = edges.try_inverse().expect("a tetrahedron with a volume");
        let inverse_rest = [0, 1, 2].map(|row| [0, 1, 2].map(|column| inverse[(row, column)]));
        let volume = edges.determinant() / 6.0;
        let params = stable_neo_hookean::Params { inverse_rest, volume, mu: 2e5, lambda: 8e5 };
        let bodies = corners.map(|corner| grid[corner]);
        // Between corners that are all held there is nothing to move.
        if scene.world.add(params, bodies).is_ok() {
            let [a, b, c, d] = bodies;
            scene.edges.extend([(a, b), (a, c), (a, d), (b, c), (b, d), (c, d)]);
        }
    }
    scene
}

/// Five tetrahedra a cell, mirrored from cell to cell so that their faces meet.
fn tetrahedra(cells: [usize; 3], number: &dyn Fn(usize, usize, usize) -> usize) -> Vec<[usize; 4]> {
    const CORNERS: [[usize; 4]; 5] = [[0, 1, 2, 4], [3, 2, 1, 7], [5, 4, 7, 1], [6, 7, 4, 2], [1, 2, 4, 7]];
    let mut found = Vec::new();
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                let mirror = (x + y + z) % 2;
                let corner = |k: usize| number(x + ((k & 1) ^ mirror), y + (k >> 1 & 1), z + (k >> 2 & 1));
                found.extend(CORNERS.map(|corners| corners.map(corner)));
            }
        }
    }
    found
}
