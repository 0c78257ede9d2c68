//! Bundles: L islands of equal structure that take a step together, in lanes.
//!
//! In: the islands, which must have the structure with which the bundle was made. Out: a report of each, and
//! the same bits as if each had been stepped alone. An instance whose step is not accepted is discarded, and
//! its island is advanced alone.

use super::Island;
use super::control::StepRequest;
use crate::outside::Outside;
use crate::report::Report;
use crate::step::packed::Packed;
use nalgebra::RealField;

/// L islands in lanes.
pub(crate) struct Bundle<R: RealField + Copy, const L: usize> {
    /// The numbers of the islands.
    pub(crate) members: [usize; L],
    packed: Packed<R, L>,
    /// The versions of data, loads and state that `packed` has read.
    read: [[u64; 3]; L],
}

impl<R: RealField + Copy, const L: usize> Bundle<R, L> {
    pub(crate) fn new(members: [usize; L], first: &Island<R>) -> Bundle<R, L> {
        let packed = Packed::new(&first.store, &first.batches, pulp::Arch::new());
        Bundle { members, packed, read: [[0; 3]; L] }
    }

    /// Advances all islands.
    pub(crate) fn advance(
        &mut self,
        islands: [&mut Island<R>; L],
        request: &StepRequest<'_, R>,
    ) -> [Report; L] {
        let Bundle { packed, read, .. } = self;
        let versions = islands.each_ref().map(|it| [it.data_version, it.load_version, it.state_version]);
        if (0..L).any(|lane| read[lane][0] != versions[lane][0]) {
            packed.gather(&islands.each_ref().map(|it| (&it.store, it.batches.as_slice(), it.origin)));
        }
        for (lane, island) in islands.iter().enumerate() {
            if read[lane][1] != versions[lane][1] {
                packed.read_loads(lane, &island.store);
            }
            if read[lane][2] != versions[lane][2] {
                packed.read(lane, &island.store, &island.multipliers);
            } else {
                packed.read_driven(lane, &island.store);
            }
        }
        *read = versions;
        let outside = Outside {
            gravity: request.gravity,
            time: R::zero(),
            loads: request.loads,
            origin: islands[0].origin,
        };
        let stepped = packed.step(request.h, &outside, request.settings.integrator);
        let mut lane = 0;
        islands.map(|island| {
            let at = lane;
            lane += 1;
            let outcome = stepped.outcome(at, packed.has_rows());
            if island.starts_whole(request) {
                let before = island.energy(request.gravity);
                island.save();
                packed.scatter(at, &mut island.store);
                if let Some(report) = island.finish_whole(request, before, outcome) {
                    packed.write_multipliers(at, &mut island.multipliers);
                    return report;
                }
            }
            let report = island.advance(request);
            read[at][2] = 0;
            report
        })
    }
}
