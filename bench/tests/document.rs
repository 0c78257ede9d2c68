//! The command `document` measures exactly the blocks that the documents mark as measured.

use forcec_bench::document::STEPS;
use std::collections::BTreeMap;
use std::path::Path;

/// Each block belongs to one step, and each step has its blocks; blocks of other documents are printed from the code.
#[test]
fn every_measured_block_has_its_step() {
    let mut wanted: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for step in &STEPS {
        let blocks = step.prints.iter().filter(|name| !name.contains('.'));
        wanted.entry(step.document).or_default().extend(blocks);
    }
    for (document, mut blocks) in wanted {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs").join(document);
        let text = std::fs::read_to_string(path).unwrap();
        let marks = text.split("<!-- printed: ").skip(1);
        let mut found: Vec<&str> = marks.map(|rest| rest.split(" -->").next().unwrap()).collect();
        found.sort_unstable();
        blocks.sort_unstable();
        assert_eq!(found, blocks, "{document}");
        assert_eq!(text.matches("<!-- end -->").count(), found.len(), "{document}");
    }
}
