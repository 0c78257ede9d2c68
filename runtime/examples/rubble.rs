//! Boxes fall onto a height field and come to rest: `cargo run --release -p forcec-runtime --features collision --example
//! rubble -- [BOXES [STEPS PER SECOND [SECONDS]]]`. Prints a line for each half second: what takes the time of a step, ms, and
//! what it does.

use forcec_runtime::collision::parry::math::{Pose, Rotation, Vector};
use forcec_runtime::collision::parry::shape::{HeightFieldFlags, SharedShape};
use forcec_runtime::collision::parry::utils::Array2;
use forcec_runtime::collision::{Collisions, Surface, motion};
use forcec_runtime::prelude::*;
use forcec_runtime::{Body, Error, Motion, Sleep, World};
use std::f64::consts::FRAC_PI_2;
use std::time::{Duration, Instant};

/// Cells of the height field on a side, and their width, m.
const CELLS: usize = 24;
const WIDTH: f64 = 1.0;

const SURFACE: Surface = Surface { friction: 0.8, stiffness: None, damping: None };

/// A shallow bowl with bumps.
fn height(x: f64, y: f64) -> f64 {
    0.02 * (x * x + y * y) + 0.2 * (1.3 * x).sin() * (1.1 * y).cos()
}

/// Layers of boxes of various sizes above the ground.
fn rubble(boxes: usize) -> Result<(World, Collisions, Vec<Body>), Error> {
    let (mut world, mut collisions) = (World::default(), Collisions::default());
    world.gravity = Vec3::z() * -9.81;
    world.settings.sleep = Some(Sleep { speed: 0.05, time: 0.5 });

    // The rows of a height field run along z, its columns along x, its heights along y.
    let place = |k: usize| (k as f64 / CELLS as f64 - 0.5) * CELLS as f64 * WIDTH;
    let heights: Vec<f64> =
        (0..=CELLS).flat_map(|x| (0..=CELLS).map(move |z| height(place(x), -place(z)))).collect();
    let size = Vector::new(CELLS as f64 * WIDTH, 1.0, CELLS as f64 * WIDTH);
    let heights = Array2::new(CELLS + 1, CELLS + 1, heights);
    let field = SharedShape::heightfield_with_flags(heights, size, HeightFieldFlags::FIX_INTERNAL_EDGES);
    let ground = world.add_rigid(Rigid::default(), Motion::Kinematic)?;
    let upright = Pose::from_parts(Vector::ZERO, Rotation::from_rotation_x(FRAC_PI_2));
    collisions.add_at(ground, upright, field, SURFACE);

    let mut bodies = Vec::new();
    let side = 8;
    for k in 0..boxes {
        let (layer, row, column) = (k / (side * side), k / side % side, k % side);
        let part = |n: usize| (k * n % 97) as f64 / 97.0;
        let shape = SharedShape::cuboid(0.2 + 0.3 * part(29), 0.2 + 0.3 * part(41), 0.2 + 0.2 * part(53));
        let position = Vec3::new(
            1.4 * (column as f64 - 3.5) + 0.3 * part(61),
            1.4 * (row as f64 - 3.5) + 0.3 * part(71),
            2.0 + 1.4 * layer as f64,
        );
        let turn = Vec3::new(part(13) - 0.5, part(17) - 0.5, part(19) - 0.5);
        let state = Rigid { position, orientation: Quat::from_scaled_axis(turn), ..Rigid::default() };
        let body = world.add_rigid(state, motion(&shape, 500.0))?;
        collisions.add(body, shape, SURFACE);
        bodies.push(body);
    }
    Ok((world, collisions, bodies))
}

fn main() -> Result<(), Error> {
    let mut numbers = std::env::args().skip(1).map(|number| number.parse::<usize>());
    let mut number = |default| numbers.next().and_then(Result::ok).unwrap_or(default);
    let (boxes, rate, seconds) = (number(512), number(120), number(15));
    let (mut world, mut collisions, bodies) = rubble(boxes)?;
    let h = 1.0 / rate as f64;
    println!(
        "  time  broad narrow forces   step assembly  solve  pairs points changes  depth awake iterations rejected    energy"
    );
    let mut whole = Duration::ZERO;
    for half in 1..=2 * seconds {
        let mut sum = [0.0; 6];
        let (mut depth, mut changes, mut rejected, mut iterations) = (0.0_f64, 0, 0, 0);
        let (mut last, mut awake, mut energy) = (Default::default(), 0, 0.0);
        let steps = rate / 2;
        for _ in 0..steps {
            let contacts = collisions.update(&mut world, h)?;
            let clock = Instant::now();
            let report = world.step(h)?;
            let step = clock.elapsed();
            let times =
                [contacts.broad, contacts.narrow, contacts.forces, step, report.assembly, report.solve];
            for (sum, time) in sum.iter_mut().zip(times) {
                *sum += 1e3 * time.as_secs_f64() / steps as f64;
            }
            whole += contacts.broad + contacts.narrow + contacts.forces + step;
            depth = depth.max(contacts.depth);
            changes += contacts.changes;
            rejected += report.rejected;
            iterations += report.iterations;
            (last, awake, energy) = (contacts, report.awake, report.energy);
        }
        println!(
            "{:6.1} {:6.2} {:6.2} {:6.2} {:6.2}   {:6.2} {:6.2} {:6} {:6} {:7} {:6.4} {awake:5} {:10} {rejected:8} {energy:9.0}",
            half as f64 / 2.0,
            sum[0],
            sum[1],
            sum[2],
            sum[3],
            sum[4],
            sum[5],
            last.pairs,
            last.points,
            changes,
            depth,
            iterations,
        );
        if awake == 0 {
            break;
        }
    }
    let asleep = bodies.iter().filter(|&&body| world.is_asleep(body) == Ok(true)).count();
    let lowest = bodies
        .iter()
        .filter_map(|&body| world.rigid(body).ok())
        .map(|state| state.position.z - height(state.position.x, state.position.y));
    println!(
        "{asleep} of {boxes} asleep; lowest centre above ground {:.3} m; {whole:.1?} in all",
        lowest.fold(f64::MAX, f64::min)
    );
    Ok(())
}
