//! The constants of a kernel's module.
//!
//! In: a kernel. Out: names, sizes, operation counts, which entries are always zero, where entries of the
//! results are stored.

use crate::emit::rust::dialect::list;
use crate::emit::rust::{INDENT, WIDTH};
use crate::kernel::Kernel;
use crate::layout::Place;
use crate::names::{Arguments, Target};
use crate::scalar::Operations;
use crate::schedule::{Part, Statement};

/// The constants of a kernel: names, sizes, operation counts, which entries are always zero.
pub(crate) fn constants(kernel: &Kernel) -> String {
    let schedule = &kernel.schedule;
    let signature = &schedule.signature;
    let dofs = signature.dofs();
    let matrices = schedule.parts.iter().filter(|part| !part.is_list());
    let mut nonzero: Vec<(Part, Vec<Vec<u8>>)> = matrices
        .map(|part| {
            let (rows, columns) = part.shape(signature);
            (*part, vec![vec![b'.'; columns]; rows])
        })
        .collect();
    let matrices: Vec<Part> = nonzero.iter().map(|(part, _)| *part).collect();
    let place = |part: Part| matrices.iter().position(|found| *found == part);
    for statement in &schedule.statements {
        let (part, rows) = match statement {
            Statement::Store(output, _) | Statement::Add(output, ..) => {
                (output.part, output.row..output.row + 1)
            }
            Statement::Scaled { part, row, .. } => (*part, *row..*row + 1),
            Statement::Negated { part, rows, .. } => (*part, rows.clone()),
            _ => continue,
        };
        let Some(matrix) = place(part) else { continue };
        for row in rows.clone() {
            match statement {
                Statement::Store(output, _) | Statement::Add(output, ..) => {
                    nonzero[matrix].1[row][output.column] = b'x';
                }
                Statement::Negated { of, from, .. } => {
                    let Some(other) = place(*of) else { continue };
                    nonzero[matrix].1[row] = nonzero[other].1[from + row - rows.start].clone();
                }
                _ => nonzero[matrix].1[row].fill(b'x'),
            }
        }
    }
    let bodies = signature.bodies.iter().map(|body| body.name.clone());
    let parameters = kernel.given().given().map(|(_, parameter)| parameter.name.clone());
    let place = kernel.layout.row().place;
    let mut text = String::new();
    let mut constant = |summary: &str, declared: &str, value: &str| {
        let line = format!("    pub const {declared} = {value};");
        // A one-line value moves to the next line if it does not fit after the declaration.
        let fits = line.lines().next().is_some_and(|line| line.chars().count() <= WIDTH);
        let space = if fits { " " } else { "\n        " };
        text.push_str(&format!("\n    /// {summary}\n    pub const {declared} ={space}{value};\n"));
    };
    let mut names = |summary: &str, name: &str, items: &mut dyn Iterator<Item = String>| {
        let items: Vec<String> = items.map(|item| format!("{item:?}")).collect();
        let declared = format!("{name}: [&str; {}]", items.len());
        constant(summary, &declared, &list(&items, INDENT));
    };
    names("What the kernel computes.", "FORMULAS", &mut kernel.formulas.iter().cloned());
    names("The bodies, in argument order.", "BODIES", &mut bodies.into_iter());
    names("The parameters, in the order of the fields.", "PARAMETERS", &mut parameters.into_iter());
    let coordinates = signature.coordinate_names();
    names("The coordinates, in the order of `force`.", "COORDINATES", &mut coordinates.into_iter());
    let fields = Arguments::new(signature, Target::Rust);
    for (part, rows) in nonzero {
        let part = fields.result(part);
        let summary = format!("Rows of `{part}`; `.` where an entry is always zero.");
        let mut rows = rows.into_iter().map(|row| String::from_utf8_lossy(&row).into_owned());
        names(&summary, &format!("{}_NONZERO", part.to_ascii_uppercase()), &mut rows);
    }
    if kernel.once().is_some() {
        let mut fields = signature.given().map(|(_, parameter)| parameter.name.clone());
        names("What is prepared, in the order of the fields.", "PREPARED", &mut fields);
    }
    for (part, triangle) in kernel.triangles().filter(|_| place == Place::Triangle) {
        let summary = format!("Whether `{part}` is symmetric, and its upper triangle stored row by row.");
        let declared = format!("{}_TRIANGLE: bool", part.name().to_ascii_uppercase());
        constant(&summary, &declared, &triangle.to_string());
    }
    if let Some(anchored) = kernel.anchored {
        let summary = "Whether J is ±(I, −[r]×) for every rigid body and ±I for every particle.";
        constant(summary, "ANCHORED: bool", &anchored.to_string());
    }
    let packing = kernel.packing.iter().filter(|_| place == Place::Shared);
    for table in packing.flat_map(|packing| &packing.tables) {
        let summary = format!(
            "Positions of the entries of `{0}`: k > 0 is `entries[k - 1]`, k < 0 is `-entries[-k - 1]`, 0 is zero.",
            table.part
        );
        let text = |row: &[i32]| row.iter().map(i32::to_string).collect::<Vec<String>>();
        let (count, columns) = (table.entries.len() / table.columns.max(1), table.columns);
        let name = format!("{}_PLACES", table.part.name().to_ascii_uppercase());
        if table.part.is_list() {
            constant(&summary, &format!("{name}: [i32; {count}]"), &list(&text(&table.entries), INDENT));
        } else {
            let inner = format!("{INDENT}    ");
            let rows: Vec<String> = table.rows().map(|row| list(&text(row), &inner)).collect();
            constant(&summary, &format!("{name}: [[i32; {columns}]; {count}]"), &list(&rows, INDENT));
        }
    }
    if let Some(once) = kernel.once() {
        let summary = "What is computed once, as `OPERATIONS` counts.";
        constant(summary, "PREPARE_OPERATIONS: [usize; 6]", &counts_of(&once.schedule.operations()));
    }
    constant("The name of the force function.", "NAME: &str", &format!("{:?}", kernel.name));
    constant("Degrees of freedom: the length of `force`.", "DOFS: usize", &dofs.to_string());
    constant(
        "Additions, multiplications, divisions, square roots, calls and negations.",
        "OPERATIONS: [usize; 6]",
        &counts_of(&schedule.operations()),
    );
    text
}

/// Operation counts as a list.
fn counts_of(count: &Operations) -> String {
    let counts = [count.add, count.mul, count.div, count.sqrt, count.call, count.neg];
    list(&counts.map(|count| count.to_string()), INDENT)
}
