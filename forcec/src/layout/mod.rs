//! Layouts: how a kernel stores its outputs, as a table.
//!
//! A row describes a layout: its name, the outputs that it computes in place of the requested ones, and how
//! an entry of an output maps to a stored entry. The outputs are chosen before optimising, so the optimiser
//! does not depend on layouts. The storage is decided after optimising: stored outputs replace the outputs of
//! the optimised program, and are scheduled and printed like outputs.

pub mod anchors;
mod lanes;

use crate::math::exact::Exact;
use crate::model::outputs::{Array, Axis, Output, Part, Piece};
use crate::names::values::flat;
use crate::scalar::{Graph, Id, Program};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;
use std::ops::Range;

pub use lanes::Lanes;

/// Numbers of instances that a kernel can compute at once.
pub const LANES: [usize; 3] = [1, 4, 8];

/// How a kernel stores its outputs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub enum Layout {
    /// A full array per output.
    #[default]
    Dense,
    /// Each distinct entry once, with an index table.
    Packed,
    /// The matrix and the impulse of an implicit integrator.
    System,
    /// The matrix-vector products of a matrix-free solver.
    Product,
    /// An array per body, or per pair of bodies.
    Blocks,
    /// The upper triangle of a symmetric matrix.
    Symmetric,
    /// As `Blocks`, added to the caller's values.
    Accumulate,
}

/// How an entry of an output maps to a stored entry.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Place {
    /// To its row and column in the array of the output.
    Itself,
    /// To the first entry that is equal up to sign, in one list.
    Shared,
    /// To its row and column in the array of its bodies.
    Bodies,
    /// For a symmetric matrix, to an entry of the upper triangle, in a list.
    Triangle,
}

/// A row of the table of layouts.
#[derive(Debug)]
pub struct LayoutRow {
    /// The layout.
    pub layout: Layout,
    /// The name on the command line and in the suffix of a kernel's name.
    pub name: &'static str,
    /// The outputs that replace the requested ones, if any.
    pub computes: Option<&'static [Part]>,
    /// How an entry maps to a stored entry.
    pub place: Place,
    /// Whether outputs are added to the caller's values.
    pub adds: bool,
    /// A description in one line.
    pub summary: &'static str,
}

/// All layouts.
pub static LAYOUTS: [LayoutRow; 7] = [
    LayoutRow {
        layout: Layout::Dense,
        name: "dense",
        computes: None,
        place: Place::Itself,
        adds: false,
        summary: "a full array a result",
    },
    LayoutRow {
        layout: Layout::Packed,
        name: "packed",
        computes: None,
        place: Place::Shared,
        adds: false,
        summary: "each distinct entry that is not zero once, and a table that says where it goes",
    },
    LayoutRow {
        layout: Layout::System,
        name: "system",
        computes: Some(&[Part::Impulse, Part::Matrix]),
        place: Place::Itself,
        adds: false,
        summary: "the matrix h ∂F/∂V + h² ∂F/∂X and the impulse h (F + h ∂F/∂X V) of an implicit step",
    },
    LayoutRow {
        layout: Layout::Product,
        name: "product",
        computes: Some(&[Part::DfdxProduct, Part::DfdvProduct]),
        place: Place::Itself,
        adds: false,
        summary: "∂F/∂X p and ∂F/∂V p for a direction p, without the matrices",
    },
    LayoutRow {
        layout: Layout::Blocks,
        name: "blocks",
        computes: None,
        place: Place::Bodies,
        adds: false,
        summary: "an array a body of the force and a pair of bodies of a matrix, where it is not all zero",
    },
    LayoutRow {
        layout: Layout::Symmetric,
        name: "symmetric",
        computes: None,
        place: Place::Triangle,
        adds: false,
        summary: "the upper triangle, row by row, of a matrix that is symmetric; other results in full",
    },
    LayoutRow {
        layout: Layout::Accumulate,
        name: "accumulate",
        computes: None,
        place: Place::Bodies,
        adds: true,
        summary: "as `blocks`, added through pointers to what the caller has there",
    },
];

impl Layout {
    /// The row of the layout.
    pub fn row(self) -> &'static LayoutRow {
        &LAYOUTS[self as usize]
    }

    /// The layout with this name.
    pub fn named(name: &str) -> Option<Layout> {
        LAYOUTS.iter().find(|row| row.name == name).map(|row| row.layout)
    }

    /// Names of all layouts, separated by commas.
    pub fn names() -> String {
        let names: Vec<String> = LAYOUTS.iter().map(|row| format!("`{}`", row.name)).collect();
        names.join(", ")
    }

    /// The suffix of the name of a kernel or file with this number of lanes: `_packed_x4`.
    pub fn suffix(self, lanes: Lanes) -> String {
        let layout = if self == Layout::Dense { String::new() } else { format!("_{}", self.row().name) };
        match lanes {
            Lanes::Several(count) => format!("{layout}_x{count}"),
            _ => layout,
        }
    }

    /// The suffixes of a kernel's name in the names of the tables in its C header.
    pub(crate) fn tables(self) -> Vec<String> {
        let table = match self.row().place {
            Place::Shared => "_f64",
            Place::Triangle => "_triangle_f64",
            Place::Itself | Place::Bodies => return Vec::new(),
        };
        Part::choices().map(|row| format!("_{}{table}", row.name)).collect()
    }

    /// The program with the stored outputs of this layout, and the map back; `None` if the layout changes
    /// nothing. `symmetric` lists the outputs that are known to be symmetric.
    pub fn lay(self, program: &Program, symmetric: &[Part]) -> Option<(Program, Packing)> {
        match self.row().place {
            Place::Itself => None,
            Place::Shared => Some(pack(program)),
            Place::Bodies => Some(blocks(program, self.row().adds, symmetric)),
            Place::Triangle => Some(triangles(program, symmetric)),
        }
    }
}

/// The map from entries of outputs to stored entries.
#[derive(Clone, PartialEq, Debug)]
pub struct Packing {
    /// For each output, row by row: 0 for an entry that is zero and not stored, otherwise the number of the
    /// stored entry, counted from 1, and negative if the sign differs.
    pub tables: Vec<Array<i32>>,
    /// Number of entries of outputs that are not zero.
    pub nonzero: usize,
    /// The remarks in the comment of the kernel, one per line.
    pub remarks: Vec<String>,
}

impl Packing {
    fn new(program: &Program, tables: Vec<Array<i32>>, remarks: Vec<String>) -> Packing {
        let nonzero = program.outputs().filter(|id| !program.graph.is_zero(*id)).count();
        Packing { tables, nonzero, remarks }
    }

    /// Number of the stored entry of each entry, output by output, row by row.
    pub fn places(&self) -> impl Iterator<Item = i32> + '_ {
        self.tables.iter().flat_map(|table| &table.entries).copied()
    }

    /// The outputs, from the stored entries.
    pub fn unpack<N: Clone + std::ops::Neg<Output = N>>(&self, stored: &[N], zero: &N) -> Vec<N> {
        let entry = |place: i32| match place {
            0 => zero.clone(),
            1.. => stored[place as usize - 1].clone(),
            _ => -stored[place.unsigned_abs() as usize - 1].clone(),
        };
        self.places().map(entry).collect()
    }
}

/// Stores entries that are distinct up to sign in one list.
fn pack(program: &Program) -> (Program, Packing) {
    let mut packed = program.clone();
    let graph = &mut packed.graph;
    let mut list: Vec<Id> = Vec::new();
    let mut numbers: FxHashMap<Id, i32> = FxHashMap::default();
    let mut tables = Vec::new();
    if program.outputs().all(|id| graph.is_zero(id)) {
        // C has no arrays of length 0.
        list.push(graph.zero());
    }
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
                // The entry is named after its first occurrence.
                graph.set_name(unsigned, &name(output, program));
                list.len() as i32
            });
            entries.push(if negative { -number } else { number });
        }
        tables.push(Array { part: array.part, columns: array.columns, entries });
    }
    packed.signature.pieces = vec![Piece::Entries(list.len())];
    packed.arrays = vec![Array::new(Part::List(0), &packed.signature, list)];
    (packed, Packing::new(program, tables, Vec::new()))
}

/// The stored outputs of a layout, while they are being built.
struct Pieces {
    laid: Program,
    tables: Vec<Array<i32>>,
    /// Number of stored entries.
    length: i32,
}

impl Pieces {
    /// No stored outputs yet; all entries are unmapped.
    fn new(program: &Program) -> Pieces {
        let table = |array: &Array<Id>| Array {
            part: array.part,
            columns: array.columns,
            entries: vec![0; array.entries.len()],
        };
        let tables = program.arrays.iter().map(table).collect();
        Pieces { laid: Program { arrays: Vec::new(), ..program.clone() }, tables, length: 0 }
    }

    /// Stores entries of an output as `part`; each entry comes with its index in the output.
    fn store(&mut self, part: Part, columns: usize, result: usize, entries: Vec<(usize, Id)>) {
        for (at, _) in &entries {
            self.length += 1;
            self.tables[result].entries[*at] = self.length;
        }
        let entries = entries.into_iter().map(|(_, id)| id).collect();
        self.laid.arrays.push(Array { part, columns, entries });
    }

    /// Adds a stored output to the signature.
    fn next(&mut self, piece: Piece, list: bool) -> Part {
        self.laid.signature.pieces.push(piece);
        let place = self.laid.signature.pieces.len() as u16 - 1;
        if list { Part::List(place) } else { Part::Block(place) }
    }
}

/// Moving bodies, each with the range of its coordinates.
fn spans(program: &Program) -> Vec<(String, Range<usize>)> {
    let mut start = 0;
    let span = |(_, body): (usize, &crate::model::bodies::Body)| {
        start += body.kind.dofs();
        (body.name.clone(), start - body.kind.dofs()..start)
    };
    program.signature.moving().map(span).collect()
}

/// Stores an array per body, or per pair of bodies, where rows or columns are coordinates. Arrays of zeros
/// are not stored, unless all are zero; if outputs are added to the caller's, zeros are not mapped.
fn blocks(program: &Program, adds: bool, symmetric: &[Part]) -> (Program, Packing) {
    let zero = |id: &Id| program.graph.is_zero(*id);
    let empty = program.outputs().all(|id| zero(&id));
    let bodies = spans(program);
    let mut pieces = Pieces::new(program);
    let mut remarks = Vec::new();
    let mut names = FxHashSet::default();
    for (result, array) in program.arrays.iter().enumerate() {
        let (part, height) = (array.part, array.entries.len() / array.columns.max(1));
        let along = |axis: Option<Axis>, length: usize| match axis {
            Some(Axis::Coordinate) => bodies.iter().map(|(name, span)| (Some(name), span.clone())).collect(),
            _ => vec![(None, 0..length)],
        };
        let columns = along(part.row().columns, array.columns);
        let mut found: Vec<(String, Matrix)> = Vec::new();
        let mut called: BTreeMap<(usize, usize), String> = BTreeMap::new();
        let mut missing: Vec<String> = Vec::new();
        for (row, rows) in along(Some(part.row().rows), height) {
            for (column, columns) in &columns {
                let of: Vec<String> = [row, *column].into_iter().flatten().cloned().collect();
                let mut name = [&[part.name().to_owned()], of.as_slice()].concat().join("_");
                while !names.insert(name.clone()) {
                    name.push('_');
                }
                let (rows, columns) = (rows.clone(), columns.clone());
                let piece = Piece::Block {
                    part,
                    rows: rows.clone(),
                    columns: columns.clone(),
                    of,
                    name: name.clone(),
                };
                let places = rows.clone().flat_map(|row| columns.clone().map(move |column| (row, column)));
                let entries = places.map(|(row, column)| row * array.columns + column);
                let entries: Vec<(usize, Id)> = entries.map(|at| (at, array.entries[at])).collect();
                called.insert((rows.start, columns.start), name.clone());
                if entries.iter().all(|(_, id)| zero(id)) && !empty {
                    missing.push(name);
                    continue;
                }
                if !part.is_list() {
                    let entries = entries.iter().map(|(_, id)| *id).collect();
                    found.push((name, Matrix { columns: columns.len(), entries }));
                }
                let part = pieces.next(piece, part.is_list());
                pieces.store(part, columns.len(), result, entries);
            }
        }
        // Implied by the law of the force, even if entries differ.
        let mirrored = called
            .iter()
            .filter(|_| symmetric.contains(&part))
            .filter_map(|((row, column), name)| Some((name.clone(), called.get(&(*column, *row))?.clone())));
        remarks.extend(relations(&program.graph, &found, &mirrored.collect::<Vec<_>>()));
        remarks.extend(listed("all zero and not stored: ", &missing));
    }
    if adds {
        let tables = pieces.tables.iter_mut().flat_map(|table| &mut table.entries);
        tables.zip(program.outputs()).filter(|(_, id)| zero(id)).for_each(|(place, _)| *place = 0);
    }
    (pieces.laid, Packing::new(program, pieces.tables, remarks))
}

/// A block of a matrix, row by row.
struct Matrix {
    columns: usize,
    entries: Vec<Id>,
}

impl Matrix {
    fn transposed(&self) -> Matrix {
        let columns = self.entries.len() / self.columns;
        let places = (0..self.columns).flat_map(|j| (0..columns).map(move |i| (i, j)));
        Matrix { columns, entries: places.map(|(i, j)| self.entries[i * self.columns + j]).collect() }
    }

    /// Whether this is the other matrix, or its negative.
    fn is(&self, other: &Matrix, graph: &Graph, negative: bool) -> bool {
        let term = |id: &Id| {
            let (coefficient, rest) = graph.split(*id);
            graph.value(rest).map_or((coefficient.clone(), Some(rest)), |value| (&coefficient * value, None))
        };
        let same = |(x, y): (&Id, &Id)| {
            let ((c, x), (d, y)) = (term(x), term(y));
            x == y && c == if negative { -d } else { d }
        };
        self.columns == other.columns
            && self.entries.len() == other.entries.len()
            && self.entries.iter().zip(&other.entries).all(same)
    }
}

/// Relations of blocks to earlier blocks: `dfdx_a_b = −dfdx_a_a`.
fn relations(graph: &Graph, blocks: &[(String, Matrix)], mirrored: &[(String, String)]) -> Vec<String> {
    let mut known = Vec::new();
    for (place, (name, block)) in blocks.iter().enumerate() {
        let transposed = block.transposed();
        let related = |(other, before): &(String, Matrix)| {
            let ways =
                [(block, false, ""), (block, true, ""), (&transposed, false, "ᵀ"), (&transposed, true, "ᵀ")];
            let way = ways.into_iter().find(|(own, negative, _)| own.is(before, graph, *negative));
            way.map(|(_, negative, mark)| {
                format!("{name} = {}{other}{mark}", if negative { "−" } else { "" })
            })
        };
        let own = || {
            let ways = [(false, "symmetric"), (true, "antisymmetric")];
            let way = ways.into_iter().find(|(negative, _)| transposed.is(block, graph, *negative));
            way.map(|(_, way)| format!("{name} is {way}"))
        };
        let by_law = || {
            let (_, across) = mirrored.iter().find(|(own, _)| own == name)?;
            if across == name {
                return Some(format!("{name} is symmetric"));
            }
            let before = blocks[..place].iter().any(|(other, _)| other == across);
            before.then(|| format!("{name} = {across}ᵀ"))
        };
        known.extend(blocks[..place].iter().find_map(related).or_else(own).or_else(by_law));
    }
    listed("", &known)
}

/// Items separated by commas, in lines of limited width.
fn listed(head: &str, items: &[String]) -> Vec<String> {
    const WIDTH: usize = 90;
    let mut lines: Vec<String> = Vec::new();
    for item in items {
        match lines.last_mut() {
            Some(line) if line.chars().count() + item.chars().count() + 2 <= WIDTH => {
                line.push_str(&format!(", {item}"));
            }
            Some(line) => {
                line.push(',');
                lines.push(item.clone());
            }
            None => lines.push(format!("{head}{item}")),
        }
    }
    if let Some(line) = lines.last_mut() {
        line.push('.');
    }
    lines
}

/// Stores the upper triangle of a matrix that is known to be symmetric, or whose opposite entries are the
/// same node; stores other outputs in full.
fn triangles(program: &Program, symmetric: &[Part]) -> (Program, Packing) {
    let mut pieces = Pieces::new(program);
    let mut remarks = Vec::new();
    for (result, array) in program.arrays.iter().enumerate() {
        let count = array.columns;
        let at = |row: usize, column: usize| row * count + column;
        let upper = || (0..count).flat_map(|row| (row..count).map(move |column| (row, column)));
        let same = |(i, j): (usize, usize)| array.entries[at(i, j)] == array.entries[at(j, i)];
        let square = !array.part.is_list() && array.entries.len() == count * count;
        if !square || !symmetric.contains(&array.part) && !upper().all(same) {
            pieces.store(array.part, count, result, array.entries.iter().copied().enumerate().collect());
            if !array.part.is_list() {
                remarks
                    .push(format!("{} is not known to be symmetric and stored in full.", array.part.title()));
            }
            continue;
        }
        let entries = upper().map(|(i, j)| (at(i, j), array.entries[at(i, j)])).collect();
        let part = pieces.next(Piece::Triangle(array.part), true);
        pieces.store(part, 1, result, entries);
        let table = &mut pieces.tables[result].entries;
        upper().for_each(|(i, j)| table[at(j, i)] = table[at(i, j)]);
        remarks.push(format!(
            "{0} is symmetric; entry (i, j) with i <= j is {1}[i * (2 * {count} - i - 1) / 2 + j].",
            array.part.title(),
            array.part
        ));
    }
    (pieces.laid, Packing::new(program, pieces.tables, remarks))
}

fn name(output: Output, program: &Program) -> String {
    flat(&output.named(&program.signature))
}

/// The node without its sign, and whether the sign is negative.
fn unsigned(graph: &mut Graph, id: Id) -> (Id, bool) {
    let (coefficient, rest) = graph.split(id);
    let number = graph.value(rest).map_or_else(|| coefficient.clone(), |value| &coefficient * value);
    if number.is_negative() { (graph.scaled(-Exact::ONE, id), true) } else { (id, false) }
}
