//! Cloth and solids of particles.

use super::Scene;
use forcec_constraints::cloth::{dihedral, stvk_triangle};
use forcec_constraints::solids::stable_neo_hookean;
use forcec_runtime::Motion;
use forcec_runtime::nalgebra::{Matrix2, Matrix3};
use forcec_runtime::prelude::Vec3;
use std::collections::BTreeMap;

/// A square of cloth, 1 m wide with 0.2 kg/m², in the plane and fixed at two corners.
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
                let corners = [a, b, c].map(|corner| grid[corner]);
                scene.world.add(params, corners).expect("a triangle");
                scene.look.triangles.push(corners);
                for (i, j, k) in [(a, b, c), (b, c, a), (c, a, b)] {
                    opposite.entry((i.min(j), i.max(j))).or_default().push(k);
                }
            }
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

/// A bar of cells of 5 cm, each of five tetrahedra, 1000 kg/m³, fixed at one end.
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
    let mut faces: BTreeMap<[usize; 3], Vec<[usize; 3]>> = BTreeMap::new();
    for corners in tetrahedra {
        let edges = edges(corners);
        let inverse = edges.try_inverse().expect("a tetrahedron with a volume");
        let inverse_rest = [0, 1, 2].map(|row| [0, 1, 2].map(|column| inverse[(row, column)]));
        let volume = edges.determinant() / 6.0;
        let params = stable_neo_hookean::Params { inverse_rest, volume, mu: 2e5, lambda: 8e5 };
        let bodies = corners.map(|corner| grid[corner]);
        scene.world.add(params, bodies).expect("a tetrahedron with a corner that is free");
        let [a, b, c, d] = corners;
        for face in [[a, c, b], [a, b, d], [b, c, d], [a, d, c]] {
            let mut key = face;
            key.sort_unstable();
            faces.entry(key).or_default().push(face);
        }
    }
    // Faces of only one tetrahedron form the surface.
    let surface = faces.values().filter(|sides| sides.len() == 1).map(|sides| sides[0]);
    scene.look.triangles.extend(surface.map(|face| face.map(|corner| grid[corner])));
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
