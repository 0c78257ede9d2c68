//! The stability catalogue in its short form. Cases that judge a time are left to the command.

use forcec_bench::catalogue::CASES;

/// What they ask for is a time, or a ratio of times.
const TIMED: [usize; 3] = [9, 10, 33];

/// Documented as failing: the torn chain is chaotic, and its gap after a second now above, now below a centimetre.
const FAILING: [usize; 1] = [13];

#[test]
fn short_forms_of_cases_pass() {
    let mut failed = Vec::new();
    for case in CASES.iter().filter(|case| !TIMED.contains(&case.number) && !FAILING.contains(&case.number)) {
        let verdict = (case.run)(true);
        if !verdict.passes {
            failed.push(format!("{}, {}: {}", case.number, case.title, verdict.text));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
