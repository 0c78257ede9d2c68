//! Every identity: its two sides become one node of a simplifying graph, two nodes of a verbatim graph, and have the same
//! value in 320 bits where both are defined.

use forcec::internals::vector::definition::{Definition, Law, Row};
use forcec::internals::vector::identities::{IDENTITIES, Identity};
use forcec::internals::verify::probe;
use forcec_tests::{Random, compiled};

/// Points a rule, and how many of them must be regular.
const POINTS: (usize, usize) = (40, 10);

fn sides(identity: &Identity) -> String {
    let (left, right) = (identity.left, identity.right);
    format!(
        "#[constraint]\npub fn both(p: Particle, x: Real, y: Real) -> (Real, Real) {{\n    ({left}, {right})\n}}\n\n\
         #[energy]\npub fn left(p: Particle, x: Real, y: Real) -> Real {{\n    {left}\n}}\n\n\
         #[energy]\npub fn right(p: Particle, x: Real, y: Real) -> Real {{\n    {right}\n}}\n"
    )
}

fn rows(definition: &Definition) -> Vec<usize> {
    let Law::Constraint { rows, .. } = &definition.law else { panic!("`both` is a constraint") };
    let index = |row: &Row| match row {
        Row::Real(x) => x.index(),
        Row::Vector(v) => v.index(),
    };
    rows.iter().map(index).collect()
}

#[test]
fn both_sides_become_one_node_and_have_one_value() {
    let mut random = Random::new(3);
    for identity in IDENTITIES {
        let name = identity.name;
        let compiled = compiled(name, &sides(identity));
        let function = |name: &str| {
            let mut functions = compiled.functions.iter();
            functions.find(|function| function.definition.name == name).expect("it was just written")
        };
        let simplified = rows(&function("both").definition);
        let definition = &function("both").definition;
        assert_eq!(
            simplified[0],
            simplified[1],
            "{name}: {:?} is not {:?}",
            definition.graph.node(simplified[0]),
            definition.graph.node(simplified[1])
        );
        let verbatim = rows(&function("both").source);
        assert_ne!(verbatim[0], verbatim[1], "{name}: the sides are written differently");
        let mut regular = 0;
        let start = std::time::Instant::now();
        for _ in 0..POINTS.0 {
            // A particle's position and velocity, which nothing reads, then x and y.
            let mut inputs = vec![0.0; 6];
            inputs.extend([random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)]);
            let (left, right) = (function("left"), function("right"));
            let Some(apart) = probe::apart(&left.source, &right.source, &inputs) else { continue };
            assert!(apart < 1e-80, "{name}: the sides are {apart:e} apart at {:?}", &inputs[6..]);
            regular += 1;
        }
        eprintln!("{name}: {regular} points in {:.1?}", start.elapsed());
        assert!(regular >= POINTS.1, "{name}: only {regular} points are regular");
    }
}

/// The comparison sees a rule that is wrong.
#[test]
fn a_wrong_rule_is_seen() {
    let text = "#[energy]\npub fn left(p: Particle, x: Real) -> Real {\n    (x * x).sqrt()\n}\n\n\
                #[energy]\npub fn right(p: Particle, x: Real) -> Real {\n    x\n}\n";
    let compiled = compiled("wrong", text);
    let [left, right] = compiled.functions.as_slice() else { panic!("two functions") };
    let apart = |x: f64| {
        let inputs = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, x];
        probe::apart(&left.source, &right.source, &inputs).expect("a regular point")
    };
    assert_eq!(apart(0.5), 0.0);
    assert!(apart(-0.5) > 1.0);
}
