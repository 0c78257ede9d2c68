//! The work-precision measurement in its quick form, and a few steps and the picture of every scene.

use forcec_bench::picture::picture;
use forcec_bench::scenes::SCENES;
use forcec_bench::work_precision::{Measured, Options, PROBLEMS, Point, State, measure, peers};

fn measured(name: &str, rows: &[peers::Row], budget: f64) -> Measured {
    let problem = PROBLEMS.iter().find(|problem| problem.name == name).expect("a problem");
    measure(problem, rows, &Options { quick: true, budget, ..Options::default() })
}

fn at<'a>(measured: &'a Measured, maker: &str, h: f64) -> &'a Point {
    let point = measured.points.iter().find(|point| point.maker == maker && (point.h / h - 1.0).abs() < 1e-9);
    point.unwrap_or_else(|| panic!("{maker} at {h}"))
}

#[test]
fn errors_fall_as_steps_do_and_methods_of_higher_order_err_less() {
    let measured = measured("c10", &[], f64::INFINITY);
    let error = |maker: &str, h: f64| at(&measured, maker, h).error;
    let (coarse, fine) = (1.0 / 60.0, 1.0 / 120.0);
    for (maker, factor) in [("linearly-implicit-euler", 1.5), ("sdirk2", 3.0)] {
        assert!(error(maker, coarse) > factor * error(maker, fine), "{maker}");
    }
    assert!(error("sdirk2", fine) < 0.1 * error("linearly-implicit-euler", fine));
    assert!(error("rodas4", coarse) < error("sdirk2", fine));
    assert_eq!(at(&measured, "sdirk2", coarse).state, State::Plain);
    assert_eq!(at(&measured, "symplectic-euler", coarse).state, State::Shortened);
    assert!(measured.points.iter().all(|point| point.step > 0.0));
}

#[test]
fn rows_of_peers_are_read_and_compared() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("peers");
    std::fs::create_dir_all(&folder).unwrap();
    let line = |setting: &str, h: f64, shift: f64| {
        let mut scene = forcec_bench::scenes::robots(1, 1e7, true);
        for k in 0..240 {
            scene.advance(k as f64 / 240.0, 1.0 / 240.0);
        }
        let places = scene.positions();
        let places = places.iter().flat_map(|at| [at.x + shift, at.y, at.z]).map(|x| x.to_string());
        format!("Engine,1.0,{setting},ben25,{h},100,,{}\n", places.collect::<Vec<String>>().join(" "))
    };
    let head = "engine,version,setting,scene,h,us,drift,positions\n";
    let text =
        [line("reference", 1e-4, 0.0), line("reference", 2e-4, 0.0), line("joints", 1e-2, 1e-3)].concat();
    std::fs::write(folder.join("engine.csv"), format!("{head}{text}")).unwrap();
    let rows = peers::read(&folder).unwrap();
    // No time for runs of ours.
    let measured = measured("ben25", &rows, 0.0);
    assert!(measured.points.iter().all(|point| point.is_peer));
    let theirs = at(&measured, "Engine joints", 1e-2);
    assert!(theirs.is_peer && (theirs.error / 1e-3 - 1.0).abs() < 1e-9, "{theirs:?}");
    assert!((theirs.cost() - 10.0).abs() < 1e-9, "100 µs a step of 10 ms");
    assert!(measured.reference.starts_with("Engine 1.0"));

    std::fs::write(folder.join("engine.csv"), format!("{head}Engine,1.0,joints,ben25\n")).unwrap();
    assert!(peers::read(&folder).unwrap_err().contains("no row"));
}

#[test]
fn every_scene_steps_and_has_a_picture() {
    for (name, _, make) in &SCENES {
        let mut scene = make();
        let mut energies = vec![scene.world.energy()];
        for step in 0..2 {
            let report = scene.advance(step as f64 * scene.step, scene.step);
            assert_eq!(report.quarantined, 0, "{name}");
            energies.push(report.energy);
        }
        let text = picture(&scene, &energies, scene.step);
        let faces = text.matches("<path fill=\"#").count();
        assert!(faces >= scene.look.boxes.len().max(3), "{name}: {faces} faces");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{name}");
    }
}
