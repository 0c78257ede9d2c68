//! Groups of awake islands that are stepped in lanes.
//!
//! In: the awake islands and the settings. Out: bundles of 8, 4 or 2 islands of equal structure, and the
//! islands that are left alone. Groups change when islands sleep, wake, join, split or change; a bundle of the
//! same unchanged islands is kept.

use crate::island::Island;
use crate::island::bundle::Bundle;
use crate::island::control::StepRequest;
use crate::report::Report;
use crate::settings::Settings;
use crate::system::lanes::widest;
use nalgebra::RealField;
use std::collections::BTreeMap;

/// The islands that are stepped, by how many at once.
pub(crate) struct Groups<R: RealField + Copy> {
    eight: Vec<Bundle<R, 8>>,
    four: Vec<Bundle<R, 4>>,
    two: Vec<Bundle<R, 2>>,
    alone: Vec<usize>,
    /// The width and the versions of structure for which the groups were made.
    width: usize,
    structures: Vec<(usize, u64)>,
    reports: Vec<Report>,
}

impl<R: RealField + Copy> Default for Groups<R> {
    fn default() -> Groups<R> {
        Groups {
            eight: Vec::new(),
            four: Vec::new(),
            two: Vec::new(),
            alone: Vec::new(),
            width: 0,
            structures: Vec::new(),
            reports: Vec::new(),
        }
    }
}

impl<R: RealField + Copy> Groups<R> {
    /// Groups these islands by how many the method of the settings steps at once.
    pub(crate) fn update(&mut self, islands: &[Island<R>], awake: &[usize], settings: &Settings<R>) {
        let explicit = settings.integrator.is_explicit();
        let width = if explicit { settings.lanes.unwrap_or_else(widest::<R>) } else { 1 };
        let structures = || awake.iter().map(|&number| (number, islands[number].structure_version));
        if self.width == width && structures().eq(self.structures.iter().copied()) {
            return;
        }
        let kept: BTreeMap<usize, u64> = self.structures.iter().copied().collect();
        let same = |members: &[usize]| {
            members.iter().all(|it| kept.get(it) == islands.get(*it).map(|island| &island.structure_version))
        };
        let mut old = std::mem::take(self);
        old.eight.retain(|bundle| same(&bundle.members));
        old.four.retain(|bundle| same(&bundle.members));
        old.two.retain(|bundle| same(&bundle.members));
        if width <= 1 {
            self.alone.extend(awake);
            self.width = width;
            self.structures = structures().collect();
            self.reports = old.reports;
            return;
        }
        let mut alike: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        for &number in awake {
            alike.entry(islands[number].structure()).or_default().push(number);
        }
        for members in alike.into_values() {
            let mut rest = members.as_slice();
            take(&mut self.eight, &mut old.eight, &mut rest, islands, width);
            take(&mut self.four, &mut old.four, &mut rest, islands, width);
            take(&mut self.two, &mut old.two, &mut rest, islands, width);
            self.alone.extend(rest);
        }
        self.width = width;
        self.structures = structures().collect();
        self.reports = old.reports;
    }

    /// Advances all islands; passes on the reports in their order.
    pub(crate) fn advance(
        &mut self,
        islands: &mut [Island<R>],
        awake: &[usize],
        request: &StepRequest<'_, R>,
        mut done: impl FnMut(&Report),
    ) where
        R: Send + Sync,
    {
        self.reports.clear();
        self.reports.resize(islands.len(), Report::default());
        let Groups { eight, four, two, alone, reports, .. } = self;
        #[cfg(feature = "rayon")]
        if eight.len() + four.len() + two.len() + alone.len() > 1 && rayon::current_num_threads() > 1 {
            let mut each: Vec<Option<(&mut Island<R>, &mut Report)>> =
                islands.iter_mut().zip(reports.iter_mut()).map(Some).collect();
            let each = &mut each;
            rayon::scope(|scope| {
                spawn(scope, eight, each, request);
                spawn(scope, four, each, request);
                spawn(scope, two, each, request);
                for &number in alone.iter() {
                    if let Some((island, report)) = each[number].take() {
                        scope.spawn(move |_| *report = island.advance(request));
                    }
                }
            });
            awake.iter().for_each(|&number| done(&self.reports[number]));
            return;
        }
        run(eight, islands, reports, request);
        run(four, islands, reports, request);
        run(two, islands, reports, request);
        for &number in alone.iter() {
            reports[number] = islands[number].advance(request);
        }
        awake.iter().for_each(|&number| done(&self.reports[number]));
    }
}

/// Makes bundles of L of the members, if the width allows; keeps those that exist.
fn take<R: RealField + Copy, const L: usize>(
    bundles: &mut Vec<Bundle<R, L>>,
    old: &mut Vec<Bundle<R, L>>,
    rest: &mut &[usize],
    islands: &[Island<R>],
    width: usize,
) {
    while let Some((members, after)) = rest.split_first_chunk::<L>().filter(|_| L <= width) {
        *rest = after;
        let known = old.iter().position(|bundle| bundle.members == *members);
        bundles.push(match known {
            Some(at) => old.swap_remove(at),
            None => Bundle::new(*members, &islands[members[0]]),
        });
    }
}

fn run<R: RealField + Copy, const L: usize>(
    bundles: &mut [Bundle<R, L>],
    islands: &mut [Island<R>],
    reports: &mut [Report],
    request: &StepRequest<'_, R>,
) {
    for bundle in bundles {
        if let Ok(members) = islands.get_disjoint_mut(bundle.members) {
            for (number, report) in bundle.members.into_iter().zip(bundle.advance(members, request)) {
                reports[number] = report;
            }
        }
    }
}

#[cfg(feature = "rayon")]
fn spawn<'s, R: RealField + Copy + Send + Sync, const L: usize>(
    scope: &rayon::Scope<'s>,
    bundles: &'s mut [Bundle<R, L>],
    each: &mut [Option<(&'s mut Island<R>, &'s mut Report)>],
    request: &'s StepRequest<'_, R>,
) {
    for bundle in bundles {
        let (mut members, mut reports) = (Vec::with_capacity(L), Vec::with_capacity(L));
        for number in bundle.members {
            if let Some((island, report)) = each[number].take() {
                members.push(island);
                reports.push(report);
            }
        }
        if let Ok(members) = <[&mut Island<R>; L]>::try_from(members) {
            scope.spawn(move |_| {
                let made = bundle.advance(members, request);
                reports.into_iter().zip(made).for_each(|(report, made)| *report = made);
            });
        }
    }
}
