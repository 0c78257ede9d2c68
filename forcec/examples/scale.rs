//! scale
use forcec::bodies::*;
use forcec::definition::*;
use forcec::exact::Exact;
use forcec::vector::*;
fn main() {
    for n in [100, 1000, 10000] {
        let mut s = Signature::default();
        for i in 0..2 {
            s.bodies.push(Body { name: ((b'a' + i as u8) as char).to_string(), kind: BodyKind::PARTICLE });
        }
        s.parameters.push(Parameter { name: "k".into(), ty: ParameterType::Real, domain: Domain::Any });
        let mut g = Graph::new(s.clone());
        let x = g.triple(s.body_slot(0, Role::Position).unwrap());
        let y = g.triple(s.body_slot(1, Role::Position).unwrap());
        let d = g.vector_sub(y, x);
        let (mut p, mut q) = (g.component(d, 0), g.component(d, 1));
        let k = g.entry(s.parameter_slot(0, 0));
        for i in 0..n {
            let t = g.mul(p, q);
            let u = g.mul(k, p);
            let t = g.sum(Exact::ratio(1, 3), vec![(Exact::ONE, t), (Exact::ratio(-1, 2), u)]);
            let t = if i % 4 == 0 { g.call(forcec::ops::Function::Sin, &[t]) } else { t };
            let t = g.let_real("t", t);
            p = q;
            q = t;
        }
        let def = Definition {
            name: "chain".into(),
            docs: vec![],
            span: Default::default(),
            graph: g,
            law: Law::Energy(q),
        };
        let t0 = std::time::Instant::now();
        let derived = forcec::derive::derive(&def);
        let t1 = t0.elapsed();
        let nv = derived.lie.graph.len();
        let mut p = forcec::optimize::lower::lower(derived);
        let t2 = t0.elapsed();
        println!(
            "n {n}: derive {t1:?} vector {nv}, lower {t2:?} scalar {} ops {}",
            p.graph.len(),
            p.operations().total()
        );
        for pass in &forcec::optimize::PASSES {
            let t = std::time::Instant::now();
            p = pass.run(&p);
            println!(
                "   {} {:?} -> {} nodes {} ops",
                pass.name,
                t.elapsed(),
                p.graph.len(),
                p.operations().total()
            );
        }
    }
}
