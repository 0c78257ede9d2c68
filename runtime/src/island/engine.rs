//! The data of implicit steps of an island: its nodes and the pattern of its system.
//!
//! In: the bodies and forces of an island. Out: the data of a step, with 3 × 3 blocks for particles and 6 × 6
//! blocks otherwise; forces know where their blocks are. Rigid rows are nodes too, which are eliminated after
//! a body that they hold.

use super::Island;
use crate::state::Motion;
use crate::step::Model;
use crate::system::assemble::{Assembly, Closing};
use crate::system::batch::joints;
use crate::system::order::{Joint, Role, predecessors, roles};
use crate::system::sparse::System;
use nalgebra::{RealField, SVector};
use std::collections::BTreeSet;

/// The data of a step, by block size.
pub(super) enum Engine<R: RealField + Copy> {
    Three(Box<Model<R, 3>>),
    Six(Box<Model<R, 6>>),
}

impl<R: RealField + Copy> Island<R> {
    /// Numbers nodes and makes the system.
    pub(super) fn build(&mut self) -> Engine<R> {
        let (nodes, dofs) = self.store.nodes();
        let mut neighbours = vec![BTreeSet::new(); dofs.len()];
        for batch in &self.batches {
            for at in 0..batch.entries().len() {
                let bodies = batch.kinds().iter().zip(batch.indices(at));
                let own: Vec<usize> =
                    bodies.filter_map(|(&kind, &index)| nodes[kind as usize][index]).collect();
                for &a in &own {
                    neighbours[a].extend(own.iter().filter(|&&b| b != a));
                }
            }
        }
        // Rigid rows are nodes too, after those of bodies.
        let joints = joints(&self.batches, &nodes);
        for joint in &joints {
            let node = neighbours.len();
            joint.bodies.iter().for_each(|&body| _ = neighbours[body].insert(node));
            neighbours.push(joint.bodies.iter().copied().collect());
        }
        let turns = self.store.members[0].iter().any(|member| member.motion != Motion::Kinematic);
        if turns || joints.iter().any(|joint| joint.rows > 3) {
            Engine::Six(Box::new(self.model(nodes, &dofs, neighbours, &joints)))
        } else {
            Engine::Three(Box::new(self.model(nodes, &dofs, neighbours, &joints)))
        }
    }

    fn model<const D: usize>(
        &mut self,
        mut nodes: [Vec<Option<usize>>; 2],
        dofs: &[usize],
        neighbours: Vec<BTreeSet<usize>>,
        joints: &[Joint],
    ) -> Model<R, D> {
        let bodies = dofs.len();
        let roles = roles(dofs, joints);
        let (system, place) = System::<R, D>::new(&neighbours, &predecessors(bodies, joints, &roles));
        for node in nodes.iter_mut().flatten().flatten() {
            *node = place[*node];
        }
        self.neighbours = vec![Vec::new(); place.len()];
        for (node, near) in neighbours.into_iter().enumerate() {
            self.neighbours[place[node]] = near.into_iter().map(|other| place[other]).collect();
        }
        for batch in &mut self.batches {
            batch.place(&|(kind, row), (other, column)| {
                let row = nodes[kind as usize][row]?;
                Some(system.place(row, nodes[other as usize][column]?))
            });
        }
        let mut next = bodies;
        for batch in self.batches.iter_mut().filter(|batch| batch.is_rigid()) {
            let own = (next..next + batch.entries().len()).map(|joint| place[joint]).collect::<Vec<_>>();
            next += own.len();
            batch.place_rows(own, &|joint, (kind, index)| {
                let body = nodes[kind as usize][index]?;
                Some([system.place(joint, body), system.place(body, joint)])
            });
        }
        let mut is_joint = vec![false; place.len()];
        place[bodies..].iter().for_each(|&joint| is_joint[joint] = true);
        let closing = joints.iter().zip(&roles).zip(&place[bodies..]);
        let closing = closing.filter(|((_, role), _)| **role == Role::Closes).map(|((joint, _), &at)| {
            let body = |&body: &usize| (place[body], system.place(at, place[body]));
            Closing { joint: at, rows: joint.rows, bodies: joint.bodies.iter().map(body).collect() }
        });
        let closing = closing.collect();
        let zeros = vec![SVector::zeros(); place.len()];
        Model::new(Assembly {
            system,
            force: zeros.clone(),
            drift: zeros.clone(),
            driven: zeros.clone(),
            momentum: zeros,
            nodes,
            is_joint,
            closing,
            ..Assembly::default()
        })
    }
}
