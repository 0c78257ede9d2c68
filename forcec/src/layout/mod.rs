//! Where results stand in a kernel's output: layouts, as a table.
//!
//! A layout is a row: its name, what it computes in place of what is asked for, and how an entry of a result maps to a
//! place. What is computed is decided before optimising, so that the optimiser knows nothing of layouts; where it
//! stands is decided after it, on the program that was optimised: results become pieces, which are scheduled and
//! printed as results are.

use crate::math::exact::Exact;
use crate::model::outputs::{Array, Axis, Output, Part, Piece};
use crate::scalar::{Graph, Id, Program};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;
use std::ops::Range;

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
    /// An array a body, or a pair of them.
    Blocks,
    /// Of a symmetric matrix its upper triangle.
    Symmetric,
    /// Added to the caller's blocks.
    Accumulate,
}

/// How an entry of a result maps to a place.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Place {
    /// Its row and column of the array of the result.
    Itself,
    /// That of the first entry that is the same up to sign, in one list.
    Shared,
    /// Its row and column of the array of its bodies.
    Bodies,
    /// Of a symmetric matrix that of the entry on the same or the other side of the diagonal, in a list.
    Triangle,
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
    /// Whether results are added to what the caller has there.
    pub adds: bool,
    /// What it is, in one line.
    pub summary: &'static str,
}

/// Every layout.
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

    /// What stands behind a kernel's name in the names of the tables that its header has in C.
    pub(crate) fn tables(self) -> Vec<String> {
        let table = match self.row().place {
            Place::Shared => "_f64",
            Place::Triangle => "_triangle_f64",
            Place::Itself | Place::Bodies => return Vec::new(),
        };
        let parts = Part::CHOICES.iter().flat_map(|(_, parts)| *parts);
        parts.map(|part| format!("_{part}{table}")).collect()
    }

    /// The program whose results stand as this layout has them, with the way back; none if that is the program itself.
    /// Some results are known to be symmetric.
    pub fn lay(self, program: &Program, symmetric: &[Part]) -> Option<(Program, Packing)> {
        match self.row().place {
            Place::Itself => None,
            Place::Shared => Some(pack(program)),
            Place::Bodies => Some(blocks(program, self.row().adds, symmetric)),
            Place::Triangle => Some(triangles(program, symmetric)),
        }
    }
}

/// Where the entries of results stand in what is stored.
#[derive(Clone, PartialEq, Debug)]
pub struct Packing {
    /// For each result, row by row: 0 where an entry is zero and not stored, else its number among all that is stored,
    /// counted from one, negative where the sign is turned.
    pub tables: Vec<Array<i32>>,
    /// How many entries of the results are not zero.
    pub nonzero: usize,
    /// What a reader is told of it, a line each.
    pub remarks: Vec<String>,
}

impl Packing {
    fn new(program: &Program, tables: Vec<Array<i32>>, remarks: Vec<String>) -> Packing {
        let nonzero = program.outputs().filter(|id| !program.graph.is_zero(*id)).count();
        Packing { tables, nonzero, remarks }
    }

    /// The place of every entry, result by result and row by row.
    pub fn places(&self) -> impl Iterator<Item = i32> + '_ {
        self.tables.iter().flat_map(|table| &table.entries).copied()
    }

    /// The results, from what is stored.
    pub fn unpack<N: Clone + std::ops::Neg<Output = N>>(&self, stored: &[N], zero: &N) -> Vec<N> {
        let entry = |place: i32| match place {
            0 => zero.clone(),
            1.. => stored[place as usize - 1].clone(),
            _ => -stored[place.unsigned_abs() as usize - 1].clone(),
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
    if program.outputs().all(|id| graph.is_zero(id)) {
        // C has no list without entries.
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
                // It is called what it would be called where it stands first.
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

/// The pieces that results are stored in, as they are made.
struct Pieces {
    laid: Program,
    tables: Vec<Array<i32>>,
    /// How many entries the pieces have.
    length: i32,
}

impl Pieces {
    /// No pieces yet; no result has a place.
    fn new(program: &Program) -> Pieces {
        let table = |array: &Array<Id>| Array {
            part: array.part,
            columns: array.columns,
            entries: vec![0; array.entries.len()],
        };
        let tables = program.arrays.iter().map(table).collect();
        Pieces { laid: Program { arrays: Vec::new(), ..program.clone() }, tables, length: 0 }
    }

    /// Stores entries of a result, each with where it stands there, as this part.
    fn store(&mut self, part: Part, columns: usize, result: usize, entries: Vec<(usize, Id)>) {
        for (at, _) in &entries {
            self.length += 1;
            self.tables[result].entries[*at] = self.length;
        }
        let entries = entries.into_iter().map(|(_, id)| id).collect();
        self.laid.arrays.push(Array { part, columns, entries });
    }

    /// The part that the next piece is.
    fn next(&mut self, piece: Piece, list: bool) -> Part {
        self.laid.signature.pieces.push(piece);
        let place = self.laid.signature.pieces.len() as u16 - 1;
        if list { Part::List(place) } else { Part::Block(place) }
    }
}

/// The bodies that move with the coordinates each has.
fn spans(program: &Program) -> Vec<(String, Range<usize>)> {
    let mut start = 0;
    let span = |(_, body): (usize, &crate::model::bodies::Body)| {
        start += body.kind.freedoms();
        (body.name.clone(), start - body.kind.freedoms()..start)
    };
    program.signature.moving().map(span).collect()
}

/// An array a body, or a pair of bodies, of what counts coordinates. One that is all zero is not stored, unless none were
/// left; where results are added, no zero has a place.
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
        // By the law of the force, whatever values show.
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

    /// Whether this is another, or its negative.
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

/// What blocks have to do with blocks before them: `dfdx_a_b = −dfdx_a_a`.
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

/// Items after each other on lines that are short enough to read.
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

/// Of a matrix that is known to be symmetric, or whose entries across the diagonal are the same value, what stands on the
/// diagonal and above.
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
    output.named(&program.signature).replace(['.', '['], "_").replace(']', "")
}

/// A node, or its negative if it is one, and whether it is.
fn unsigned(graph: &mut Graph, id: Id) -> (Id, bool) {
    let (coefficient, rest) = graph.split(id);
    let number = graph.value(rest).map_or_else(|| coefficient.clone(), |value| &coefficient * value);
    if number.is_negative() { (graph.scaled(-Exact::ONE, id), true) } else { (id, false) }
}
