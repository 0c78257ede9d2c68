//! Text forms of the graphs, one line per node: the output of `forcec show` between source and kernel.

use crate::derive::Derived;
use crate::model::outputs::Array;
use crate::scalar::{self, PassReport, Program};
use crate::show::formula::{Dialect, Formulas};
use crate::vector::{Graph, Node};
use std::fmt::{self, Write};

/// Operation counts and distinct outputs after lowering and after every pass.
pub fn passes(report: &[PassReport]) -> String {
    let mut text = format!(
        "{:<14}{:>6}{:>6}{:>6}{:>6}{:>6}{:>7}{:>10}\n",
        "pass", "add", "mul", "div", "sqrt", "call", "total", "distinct"
    );
    for PassReport { pass, operations: ops, distinct } in report {
        let _ = writeln!(
            text,
            "{pass:<14}{:>6}{:>6}{:>6}{:>6}{:>6}{:>7}{distinct:>10}",
            ops.add,
            ops.mul,
            ops.div,
            ops.sqrt,
            ops.call,
            ops.total()
        );
    }
    text
}

/// The vector graph: id, operation, operands; then the name of a `let`.
impl fmt::Display for Graph {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, node) in self.nodes().enumerate() {
            let slot = |slot| self.signature.slot_name(slot);
            let base = |s| self.signature.whole_name(s);
            let (letter, text) = match node {
                Node::Constant(value) => ('r', format!("{value}")),
                Node::Entry(s) => ('r', slot(*s)),
                Node::Sum(constant, terms) => {
                    let mut parts: Vec<String> = terms.iter().map(|(c, x)| format!("{c} {x}")).collect();
                    if !constant.is_zero() {
                        parts.insert(0, constant.to_string());
                    }
                    ('r', format!("sum {}", parts.join(", ")))
                }
                Node::Product(factors) => {
                    let parts: Vec<String> = factors.iter().map(|(x, e)| format!("{x}^{e}")).collect();
                    ('r', format!("product {}", parts.join(" ")))
                }
                Node::Dot(u, v) => ('r', format!("dot {u} {v}")),
                Node::Component(v, axis) => {
                    ('r', format!("component {v} {}", ["x", "y", "z"][*axis as usize]))
                }
                Node::Norm(v) => ('r', format!("norm {v}")),
                Node::TurnReal(turn) => ('r', format!("turn{} w", factors(self, turn))),
                Node::TurnVector(turn) => ('v', format!("turn{} xyz", factors(self, turn))),
                Node::Call(function, arguments) => {
                    let order = function.order().map_or(String::new(), |n| n.to_string());
                    let arguments: String = arguments.iter().map(|x| format!(" {x}")).collect();
                    ('r', format!("{}{order}{arguments}", function.row().name))
                }
                Node::Select(c, x, y) => ('r', format!("select {c} {x} {y}")),
                Node::Let(x) => ('r', format!("let {x}")),
                Node::Offset(x, number) => ('r', format!("offset {x} {number}")),
                Node::Triple(s) => ('v', base(*s)),
                Node::Difference(p, q) => ('v', format!("{} − {}", base(*p), base(*q))),
                Node::VectorOffset(v, numbers) => {
                    let [x, y, z] = &**numbers;
                    ('v', format!("offset {v} {x} {y} {z}"))
                }
                Node::VectorSum(terms) => {
                    let parts: Vec<String> = terms.iter().map(|(c, v)| format!("{c} {v}")).collect();
                    ('v', format!("sum {}", parts.join(", ")))
                }
                Node::Scale(s, v) => ('v', format!("scale {s} {v}")),
                Node::Cross(u, v) => ('v', format!("cross {u} {v}")),
                Node::Rotate(q, inverse, v) => {
                    ('v', format!("rotate {}{} {v}", base(*q), if *inverse { "⁻¹" } else { "" }))
                }
                Node::Pack([x, y, z]) => ('v', format!("pack {x} {y} {z}")),
                Node::VectorSelect(c, u, v) => ('v', format!("select {c} {u} {v}")),
                Node::VectorLet(v) => ('v', format!("let {v}")),
                Node::Known(value) => ('b', value.to_string()),
                Node::Compare(comparison, x, y) => ('b', format!("{comparison:?} {x} {y}").to_lowercase()),
                Node::And(a, b) => ('b', format!("and {a} {b}")),
                Node::Or(a, b) => ('b', format!("or {a} {b}")),
                Node::Not(a) => ('b', format!("not {a}")),
            };
            match self.name(index) {
                Some(name) => writeln!(f, "{letter}{index} = {text}    # {name}")?,
                None => writeln!(f, "{letter}{index} = {text}")?,
            }
        }
        Ok(())
    }
}

/// The factors of a product of quaternions.
fn factors(graph: &Graph, turn: &[(crate::model::bodies::Slot, bool)]) -> String {
    let factor = |(slot, inverse): &(_, bool)| {
        format!(" {}{}", graph.signature.whole_name(*slot), if *inverse { "⁻¹" } else { "" })
    };
    turn.iter().map(factor).collect()
}

/// Forces and blocks in normal form, `s I + [k]× + Σ u vᵀ`; drift and Jᵀ λ where outputs need them.
pub fn derivative(derived: &mut Derived, dialect: Dialect) -> String {
    let mut blocks = Vec::new();
    let (forces, pull) = (derived.forces.clone(), derived.pull.clone());
    let (pose, velocity) = (derived.pose.clone(), derived.velocity.clone());
    for (is_pull, rows, columns) in
        [(false, &forces, &pose), (false, &forces, &velocity), (true, &pull, &pose)]
    {
        for (row, pieces) in rows {
            for (column, moves) in columns {
                let mut terms = Vec::new();
                for (c, piece) in pieces {
                    for (d, variable) in moves {
                        terms.push((c * d, derived.tangent.matrix(*piece, *variable)));
                    }
                }
                let terms: Vec<_> = terms.iter().map(|(c, m)| (c.clone(), &**m)).collect();
                let matrix = crate::derive::block::Matrix::sum(&mut derived.tangent.graph, &terms);
                blocks.push((is_pull, *row, *column, matrix));
            }
        }
    }
    let graph = &derived.tangent.graph;
    let mut roots: Vec<u32> = Vec::new();
    for (c, rate) in &derived.rows {
        roots.extend([c.0, rate.0]);
    }
    roots.extend(derived.drifts.iter().map(|drift| drift.0));
    for (_, pieces) in forces.iter().chain(&pull) {
        roots.extend(pieces.iter().map(|(_, v)| v.0));
    }
    for (.., matrix) in &blocks {
        roots.extend([matrix.identity.0, matrix.skew.0]);
        roots.extend(matrix.outer.iter().flat_map(|(u, v)| [u.0, v.0]));
        roots.extend(matrix.turned.iter().flat_map(|turned| [turned.identity.0, turned.skew.0]));
    }
    roots.sort_unstable();
    roots.dedup();
    let formulas = Formulas::new(graph, dialect, &roots);
    let latex = dialect == Dialect::Latex;
    let mut lines: Vec<(String, String)> =
        formulas.lines().map(|(name, text)| (name.to_owned(), text.to_owned())).collect();
    for (k, (c, _)) in derived.rows.iter().enumerate() {
        let name = if latex { format!("C_{{{}}}", k + 1) } else { format!("C[{k}]") };
        lines.push((name, formulas.formula(c.index()).to_owned()));
    }
    for (k, drift) in derived.drifts.iter().enumerate() {
        let name = if latex { format!("(\\dot J V)_{{{}}}", k + 1) } else { format!("drift[{k}]") };
        lines.push((name, formulas.formula(drift.index()).to_owned()));
    }
    let coordinate = |block: &crate::model::bodies::Block| {
        let body = &graph.signature.bodies[block.body as usize].name;
        use crate::model::bodies::Role::{AngularVelocity, Orientation, Position, Velocity};
        match (block.role, latex) {
            (Position, true) => format!("\\mathbf x_{{\\mathrm{{{body}}}}}"),
            (Orientation, true) => format!("\\boldsymbol\\theta_{{\\mathrm{{{body}}}}}"),
            (Velocity, true) => format!("\\mathbf v_{{\\mathrm{{{body}}}}}"),
            (AngularVelocity, true) => format!("\\boldsymbol\\omega_{{\\mathrm{{{body}}}}}"),
            (Position, false) => format!("x_{body}"),
            (Orientation, false) => format!("θ_{body}"),
            (Velocity, false) => format!("v_{body}"),
            (AngularVelocity, false) => format!("ω_{body}"),
        }
    };
    let force = |is_pull: bool, block: &crate::model::bodies::Block| {
        if is_pull {
            let product = if latex { "(J^\\top \\hat\\lambda)" } else { "(Jᵀλ)" };
            let of = coordinate(block);
            return if latex { format!("{product}_{{{of}}}") } else { format!("{product}_{of}") };
        }
        let body = &graph.signature.bodies[block.body as usize].name;
        let symbol = if block.role == crate::model::bodies::Role::Position { "f" } else { "τ" };
        match (latex, symbol) {
            (true, "f") => format!("\\mathbf f_{{\\mathrm{{{body}}}}}"),
            (true, _) => format!("\\boldsymbol\\tau_{{\\mathrm{{{body}}}}}"),
            (false, _) => format!("{symbol}_{body}"),
        }
    };
    for (is_pull, sums) in [(false, &forces), (true, &pull)] {
        lines.extend(sums.iter().map(|(block, sum)| (force(is_pull, block), formulas.combination(sum))));
    }
    for (is_pull, row, column, matrix) in &blocks {
        let name = if latex {
            format!("\\frac{{\\partial {}}}{{\\partial {}}}", force(*is_pull, row), coordinate(column))
        } else {
            format!("∂{}/∂{}", force(*is_pull, row), coordinate(column))
        };
        lines.push((name, formulas.matrix(matrix)));
    }
    let mut text = String::new();
    if latex {
        text.push_str("\\begin{align*}\n");
    }
    for (name, formula) in lines {
        let line = if latex {
            writeln!(text, "{name} &= {formula} \\\\")
        } else {
            writeln!(text, "{name} = {formula}")
        };
        line.expect("writing to a string does not fail");
    }
    if latex {
        text.push_str("\\end{align*}\n");
    }
    text
}

/// The scalar graph: id, operation, operands, name; then the outputs that are not zero.
impl fmt::Display for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let live = self.live();
        for (id, node) in self.graph.iter().filter(|(id, _)| live[id.index()]) {
            let slot = |slot| self.signature.slot_name(slot);
            let list = |ids: &[scalar::Id]| ids.iter().map(|id| format!(" {id}")).collect::<String>();
            let text = match node {
                scalar::Node::Constant(value) => value.to_string(),
                scalar::Node::Input(s) => slot(*s),
                scalar::Node::Difference(p, q) => format!("{} − {}", slot(*p), slot(*q)),
                scalar::Node::Offset(p, number) => format!("offset {} {number}", slot(*p)),
                scalar::Node::Sum(constant, terms) => {
                    let mut parts: Vec<String> = terms.iter().map(|(c, x)| format!("{c} {x}")).collect();
                    if !constant.is_zero() {
                        parts.insert(0, constant.to_string());
                    }
                    format!("sum {}", parts.join(", "))
                }
                scalar::Node::Product(factors) => {
                    let power =
                        |(x, e): &(scalar::Id, u32)| if *e == 1 { x.to_string() } else { format!("{x}^{e}") };
                    format!("product {}", factors.iter().map(power).collect::<Vec<_>>().join(" "))
                }
                scalar::Node::Multiple(c, x) => format!("multiple {c} {x}"),
                scalar::Node::Held(x) => format!("held {x}"),
                scalar::Node::Written(operator, x, y) => {
                    format!("written {operator:?} {x} {y}").to_lowercase()
                }
                scalar::Node::Recip(x) => format!("recip {x}"),
                scalar::Node::Call(function, arguments) => {
                    let order = function.order().map_or(String::new(), |n| n.to_string());
                    format!("{}{order}{}", function.row().name, list(arguments))
                }
                scalar::Node::Select(c, x, y) => format!("select{}", list(&[*c, *x, *y])),
                scalar::Node::Known(value) => value.to_string(),
                scalar::Node::Compare(comparison, x, y) => format!("{comparison:?} {x} {y}").to_lowercase(),
                scalar::Node::And(a, b) => format!("and {a} {b}"),
                scalar::Node::Or(a, b) => format!("or {a} {b}"),
                scalar::Node::Not(a) => format!("not {a}"),
            };
            match self.graph.name(id) {
                Some(name) => writeln!(f, "{id} = {text}    # {name}")?,
                None => writeln!(f, "{id} = {text}")?,
            }
        }
        for (output, id) in self.arrays.iter().flat_map(Array::outputs) {
            if output.part.is_list() || !self.graph.is_zero(*id) {
                writeln!(f, "{} = {id}", output.named(&self.signature))?;
            }
        }
        Ok(())
    }
}
