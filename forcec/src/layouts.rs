//! Where results stand in a kernel's output: layouts, as a table.
//!
//! A layout is a row: its name, what it computes in place of what is asked for, and how an entry of a result maps to a
//! place. What is computed is decided before optimising, so that the optimiser knows nothing of layouts; where it
//! stands is decided after it, on the program that was optimised.

use crate::exact::Exact;
use crate::outputs::{Array, Output, Part};
use crate::scalar::{Graph, Id, Program};
use rustc_hash::FxHashMap;

/// How many instances a kernel may compute at once.
pub const LANES: [usize; 3] = [1, 4, 8];

/// Where the results of a kernel stand.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub enum Layout {
    /// A full array a result.
    #[default]
    Dense,
    /// Each distinct entry once, and a table.
    Packed,
    /// What an implicit integrator consumes.
    System,
    /// What a matrix-free solver consumes.
    Product,
}

/// How an entry of a result maps to a place.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Place {
    /// Its row and column of the array of the result.
    Itself,
    /// That of the first entry that is the same up to sign, in one list.
    Shared,
}

/// What is known of a layout.
#[derive(Debug)]
pub struct LayoutRow {
    /// Which it is.
    pub layout: Layout,
    /// Its name on the command line, and behind the name of a kernel.
    pub name: &'static str,
    /// What it computes, if that is not what is asked for.
    pub computes: Option<&'static [Part]>,
    /// How an entry maps to a place.
    pub place: Place,
    /// What it is, in one line.
    pub summary: &'static str,
}

/// Every layout.
pub static LAYOUTS: [LayoutRow; 4] = [
    LayoutRow {
        layout: Layout::Dense,
        name: "dense",
        computes: None,
        place: Place::Itself,
        summary: "a full array a result",
    },
    LayoutRow {
        layout: Layout::Packed,
        name: "packed",
        computes: None,
        place: Place::Shared,
        summary: "each distinct entry that is not zero once, and a table that says where it goes",
    },
    LayoutRow {
        layout: Layout::System,
        name: "system",
        computes: Some(&[Part::Impulse, Part::Matrix]),
        place: Place::Itself,
        summary: "the matrix h ∂F/∂V + h² ∂F/∂X and the impulse h (F + h ∂F/∂X V) of an implicit step",
    },
    LayoutRow {
        layout: Layout::Product,
        name: "product",
        computes: Some(&[Part::DfdxProduct, Part::DfdvProduct]),
        place: Place::Itself,
        summary: "∂F/∂X p and ∂F/∂V p for a direction p, without the matrices",
    },
];

impl Layout {
    /// Its row.
    pub fn row(self) -> &'static LayoutRow {
        &LAYOUTS[self as usize]
    }

    /// The layout of this name.
    pub fn named(name: &str) -> Option<Layout> {
        LAYOUTS.iter().find(|row| row.name == name).map(|row| row.layout)
    }

    /// Their names, as a sentence lists them.
    pub fn names() -> String {
        let names: Vec<String> = LAYOUTS.iter().map(|row| format!("`{}`", row.name)).collect();
        names.join(", ")
    }

    /// What stands behind the name of a kernel or file of so many lanes: `_packed_x4`.
    pub fn suffix(self, lanes: usize) -> String {
        let layout = if self == Layout::Dense { String::new() } else { format!("_{}", self.row().name) };
        if lanes > 1 { format!("{layout}_x{lanes}") } else { layout }
    }

    /// The program whose results stand as this layout has them, with the way back; none if that is the program itself.
    pub fn lay(self, program: &Program) -> Option<(Program, Packing)> {
        match self.row().place {
            Place::Itself => None,
            Place::Shared => Some(pack(program)),
        }
    }
}

/// Where the entries of results stand in a list.
#[derive(Clone, PartialEq, Debug)]
pub struct Packing {
    /// For each result, row by row: 0 where an entry is zero, else its number in the list, counted from one, negative where
    /// the sign is turned.
    pub tables: Vec<Array<i32>>,
}

impl Packing {
    /// The place of every entry, result by result and row by row.
    pub fn places(&self) -> impl Iterator<Item = i32> + '_ {
        self.tables.iter().flat_map(|table| &table.entries).copied()
    }

    /// The results, from the list.
    pub fn unpack<N: Clone + std::ops::Neg<Output = N>>(&self, list: &[N], zero: &N) -> Vec<N> {
        let entry = |place: i32| match place {
            0 => zero.clone(),
            1.. => list[place as usize - 1].clone(),
            _ => -list[place.unsigned_abs() as usize - 1].clone(),
        };
        self.places().map(entry).collect()
    }
}

/// One list of the entries that differ in more than their sign, and where each goes.
fn pack(program: &Program) -> (Program, Packing) {
    let mut packed = program.clone();
    let graph = &mut packed.graph;
    let mut list: Vec<Id> = Vec::new();
    let mut numbers: FxHashMap<Id, i32> = FxHashMap::default();
    let mut tables = Vec::new();
    for array in &program.arrays {
        let mut entries = Vec::with_capacity(array.entries.len());
        for (output, id) in array.outputs() {
            if graph.is_zero(*id) {
                entries.push(0);
                continue;
            }
            let (unsigned, negative) = unsigned(graph, *id);
            let number = *numbers.entry(unsigned).or_insert_with(|| {
                list.push(unsigned);
                // It is called what it would be called where it stands first.
                graph.set_name(unsigned, &name(output, program));
                list.len() as i32
            });
            entries.push(if negative { -number } else { number });
        }
        tables.push(Array { part: array.part, columns: array.columns, entries });
    }
    packed.signature.packed = list.len();
    packed.arrays = vec![Array::new(Part::Entries, &packed.signature, list)];
    (packed, Packing { tables })
}

fn name(output: Output, program: &Program) -> String {
    output.named(&program.signature).replace(['.', '['], "_").replace(']', "")
}

/// A node, or its negative if it is one, and whether it is.
fn unsigned(graph: &mut Graph, id: Id) -> (Id, bool) {
    let (coefficient, rest) = graph.split(id);
    let number = graph.value(rest).map_or_else(|| coefficient.clone(), |value| &coefficient * value);
    if number.is_negative() { (graph.scaled(-Exact::ONE, id), true) } else { (id, false) }
}
