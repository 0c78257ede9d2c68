//! Boxes that touch each other and the ground.

use super::{Ground, Scene, box_inertia};
use forcec_runtime::Sleep;
use forcec_runtime::collision::Surface;
use forcec_runtime::collision::parry::math::{Pose, Rotation, Vector};
use forcec_runtime::collision::parry::shape::{HeightFieldFlags, SharedShape};
use forcec_runtime::collision::parry::utils::Array2;
use forcec_runtime::prelude::{Quat, Rigid, Vec3};
use std::f64::consts::FRAC_PI_2;

/// Cubes of 1 m and 1000 kg on a plane, the top one `top` times as heavy.
pub fn stack(count: usize, top: f64) -> Scene {
    let mut scene = Scene::new(5.0, 1.0 / 240.0);
    let ground = scene.ground(Ground { half: 3.0, height: |_, _| 0.0 });
    scene.shape(ground, SharedShape::halfspace(Vector::Z), Surface::default());
    for k in 0..count {
        let mass = if k + 1 == count { top } else { 1.0 } * 1e3;
        let position = Vec3::new(0.0, 0.0, 0.5 + k as f64);
        cuboid(&mut scene, Rigid { position, ..Rigid::default() }, mass, [0.5; 3], Surface::default());
    }
    scene
}

/// Cells of the height field on a side, and their width, m.
const CELLS: usize = 24;
const WIDTH: f64 = 1.0;

const ROUGH: Surface = Surface { friction: 0.8, stiffness: None, damping: None };

/// A shallow bowl with bumps.
fn bowl(x: f64, y: f64) -> f64 {
    0.02 * (x * x + y * y) + 0.2 * (1.3 * x).sin() * (1.1 * y).cos()
}

/// Layers of boxes of various sizes fall into a bowl and come to rest.
pub fn rubble(boxes: usize) -> Scene {
    let mut scene = Scene::new(15.0, 1.0 / 120.0);
    scene.world.settings.sleep = Some(Sleep { speed: 0.05, time: 0.5 });
    let half = 0.5 * CELLS as f64 * WIDTH;

    // The rows of a height field run along z, its columns along x, its heights along y.
    let place = |k: usize| k as f64 * WIDTH - half;
    let heights = (0..=CELLS).flat_map(|x| (0..=CELLS).map(move |z| bowl(place(x), -place(z)))).collect();
    let heights = Array2::new(CELLS + 1, CELLS + 1, heights);
    let size = Vector::new(2.0 * half, 1.0, 2.0 * half);
    let field = SharedShape::heightfield_with_flags(heights, size, HeightFieldFlags::FIX_INTERNAL_EDGES);
    let ground = scene.ground(Ground { half, height: bowl });
    let upright = Pose::from_parts(Vector::ZERO, Rotation::from_rotation_x(FRAC_PI_2));
    scene.collisions.get_or_insert_default().add_at(ground, upright, field, ROUGH);

    let side = 8;
    for k in 0..boxes {
        let (layer, row, column) = (k / (side * side), k / side % side, k % side);
        let part = |n: usize| (k * n % 97) as f64 / 97.0;
        let half = [0.2 + 0.3 * part(29), 0.2 + 0.3 * part(41), 0.2 + 0.2 * part(53)];
        let position = Vec3::new(
            1.4 * (column as f64 - 3.5) + 0.3 * part(61),
            1.4 * (row as f64 - 3.5) + 0.3 * part(71),
            2.0 + 1.4 * layer as f64,
        );
        let turn = Vec3::new(part(13) - 0.5, part(17) - 0.5, part(19) - 0.5);
        let state = Rigid { position, orientation: Quat::from_scaled_axis(turn), ..Rigid::default() };
        let mass = 500.0 * 8.0 * half.iter().product::<f64>();
        cuboid(&mut scene, state, mass, half, ROUGH);
    }
    scene
}

fn cuboid(scene: &mut Scene, state: Rigid, mass: f64, half: [f64; 3], surface: Surface) {
    let body = scene.rigid(state, mass, box_inertia(mass, half), half);
    scene.shape(body, SharedShape::cuboid(half[0], half[1], half[2]), surface);
}
