//! The benchmark of kernels runs, and all tools compute the same values. Times are not compared.

use forcec_bench::kernels::{BY_HAND, FLAGS, Plan, measure};
use forcec_bench::modes;
use forcec_bench::peers;
use std::path::Path;

#[test]
fn kernels_by_hand_and_emitted_ones_are_right() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("kernels");
    let plan = Plan {
        only: BY_HAND.map(str::to_owned).to_vec(),
        rounds: 3,
        flags: FLAGS.split(' ').map(str::to_owned).collect(),
        peers: Vec::new(),
    };
    let rows = measure(&plan, &folder);
    for kernel in BY_HAND {
        for maker in ["hand", "C", "Rust"] {
            let row = rows.iter().find(|row| row.kernel == kernel && row.maker.name == maker);
            let row = row.unwrap_or_else(|| panic!("{kernel} by {maker}"));
            assert!(row.error <= 1e-12, "{kernel} by {maker}: {:e}", row.error);
            assert!(row.time.is_some_and(|time| time.least > 0.0) && row.ratio.is_some(), "{row:?}");
        }
    }
}

/// A peer's file: the emitted kernel, with a modification of the results.
fn peer(formulation: &str, then: &str) -> String {
    format!(
        "/* Echo | 1.0 | {formulation} | spring | 0.5 s */\n#include \"springs.h\"\n\n\
         void echo_{formulation}(const forcec_particle_f64 *p0, const forcec_particle_f64 *p1,\n                 \
         const spring_params_f64 *params, spring_out_f64 *out)\n{{\n    spring_f64(p0, p1, params, out);\n    {then}\n}}\n"
    )
}

#[test]
fn peers_are_compared_and_a_wrong_one_is_not_timed() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("peers");
    let given = folder.join("given");
    std::fs::create_dir_all(&given).unwrap();
    std::fs::write(given.join("echo_right.c"), peer("right", "out->force[0] = 1.0 * out->force[0];"))
        .unwrap();
    std::fs::write(given.join("echo_wrong.c"), peer("wrong", "out->dfdx[5][5] *= 1.0 + 1e-8;")).unwrap();
    let plan = Plan {
        only: vec!["spring".to_owned()],
        rounds: 3,
        flags: FLAGS.split(' ').map(str::to_owned).collect(),
        peers: peers::read(&given).unwrap(),
    };
    let rows = measure(&plan, &folder);
    let lines = peers::lines(&plan, rows, &folder);
    let line = |name: &str, formulation: &str| {
        let mut lines = lines.iter();
        lines.find(|line| line.row.maker.name == name && line.row.maker.formulation == formulation).unwrap()
    };
    let right = line("Echo", "right");
    assert!(right.row.error < 1e-12 && right.row.time.is_some(), "{right:?}");
    assert_eq!(right.generation, Some(0.5));
    assert_eq!(right.size.unwrap().operations.mul, 1, "{right:?}");
    let wrong = line("Echo", "wrong");
    assert!(wrong.row.error > 1e-9 && wrong.row.time.is_none(), "{wrong:?}");
    // The emitted kernel says how many operations it has.
    let count = line("C", "").size.unwrap().operations;
    let said = format!(
        "{} add, {} mul, {} div, {} sqrt, {} call",
        count.add, count.mul, count.div, count.sqrt, count.call
    );
    let text = std::fs::read_to_string(folder.join("one/springs.c")).unwrap();
    assert!(text.contains(&said), "{said}");
    assert!(peers::table(&lines).contains("| `spring` | Echo wrong | wrong |"));
    assert!(peers::csv(&lines).lines().all(|row| row.matches(',').count() == 17), "{}", peers::csv(&lines));
}

#[test]
fn a_document_keeps_what_was_not_printed() {
    let document = "a\n<!-- printed: x -->\nold\n<!-- end -->\nb\n<!-- printed: y -->\n<!-- end -->\n";
    let printed = peers::print_into(document, &[("x", "new\n".to_owned())]).unwrap();
    assert_eq!(printed, document.replace("old", "new"));
    assert!(peers::print_into(document, &[("z", String::new())]).is_err());
}

#[test]
fn modes_err_as_they_should() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("modes");
    let points = modes::measure(&["spring"], 2, &folder);
    assert_eq!(points.len(), modes::WAYS.len());
    let error = |name: &str| {
        let point = points.iter().find(|point| point.way.name == name).unwrap();
        assert!(point.time.least > 0.0, "{name}");
        point.errors[0].normwise
    };
    assert!(error("f64 accurate") <= error("f64 balanced") && error("f64 balanced") < 1e-12);
    assert!(error("f32 accurate") <= error("f32 balanced") && error("f32 balanced") < 1e-4);
    assert!(error("f32 balanced") > 1e3 * error("f64 balanced"));
    assert_eq!(error("f64 balanced, 4 lanes"), error("f64 balanced"));
    assert!(modes::plot(&points, "spring").contains("f32 balanced"));
    assert_eq!(modes::csv(&points).lines().count(), points.len() + 1);
}
