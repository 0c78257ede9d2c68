//! Mechanisms of rigid joints against published solutions, coarse.

use forcec_bench::yardsticks::{YARDSTICKS, Yardstick, measure};

fn named(name: &str) -> &'static Yardstick {
    YARDSTICKS.iter().find(|yardstick| yardstick.name == name).expect("a yardstick")
}

#[test]
fn mechanisms_are_where_their_sources_say() {
    for (name, error, energy) in [
        ("pendulum", 1e-4, 5e-5),
        ("2 four-bar linkages", 1e-3, 1e-3),
        ("40 four-bar linkages", 1e-2, 0.1),
        ("squeezing mechanism", 1e-5, 1e-4),
    ] {
        let yardstick = named(name);
        let end = measure(yardstick, &yardstick.ways[0], None);
        assert!(end.error.is_some_and(|found| found < error), "{name}: {end:?}");
        assert!(end.energy < energy && end.steps.2 == 0, "{name}: {end:?}");
    }
}

#[test]
fn an_over_constrained_loop_and_repeated_rows_keep_their_energy() {
    let bricard = named("Bricard's mechanism");
    let end = measure(bricard, &bricard.ways[0], None);
    assert!(end.energy < 1e-3 && end.gap < 1e-9, "{end:?}");
    let ring = named("ring of 100 rods");
    let end = measure(ring, &ring.ways[0], Some(1.0));
    assert!(end.energy < 1e-3 && end.gap < 1e-7, "{end:?}");
}
