//! The outputs of a kernel, as a table.
//!
//! A row describes an output: its name in the source and in the output struct, its description, and the
//! meaning of its rows and columns. Kernels compute any subset of the outputs, in the order of the table.

use crate::model::bodies::{Domain, Parameter, ParameterType, Signature};
use std::fmt;
use std::ops::Range;

/// An output of a kernel.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Part {
    /// C, or E
    Value,
    /// dC/dt, or dE/dt
    Rate,
    /// ∂C/∂X, or ∂E/∂X
    Jacobian,
    /// D(J V) V
    Drift,
    /// λ
    Multiplier,
    /// F
    Force,
    /// ∂F/∂X
    Dfdx,
    /// ∂F/∂V
    Dfdv,
    /// h (F + h ∂F/∂X V)
    Impulse,
    /// h ∂F/∂V + h² ∂F/∂X
    Matrix,
    /// h ∂λ/∂V + h² ∂λ/∂X
    MultiplierStep,
    /// `Matrix` with given λ in the geometric stiffness
    Held,
    /// Jᵀ λ for given λ
    Pull,
    /// Σ λ D(Jᵀ) for given λ
    Geometric,
    /// ∂F/∂X p
    DfdxProduct,
    /// ∂F/∂V p
    DfdvProduct,
    /// A list of entries of other outputs, by its index in the signature
    List(u16),
    /// A matrix of entries of other outputs, by its index in the signature
    Block(u16),
}

/// The meaning of the rows or columns of an output.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Axis {
    /// Rows of C; an energy has one.
    Row,
    /// Coordinates of the moving bodies.
    Coordinate,
    /// Entries of an output that a layout makes.
    Entry,
}

/// An extra argument of kernels, which some outputs require.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Extra {
    /// The time step h
    Step,
    /// The direction p
    Direction,
    /// The multipliers in place of λ
    Multipliers,
}

impl Extra {
    /// The parameter of kernels with this signature.
    pub fn parameter(self, signature: &Signature) -> Parameter {
        let list = |length: usize| ParameterType::Array(length as u32, Box::new(ParameterType::Real));
        let (name, ty) = match self {
            Extra::Step => ("step", ParameterType::Real),
            Extra::Direction => ("direction", list(signature.dofs())),
            Extra::Multipliers => ("multipliers", list(signature.rows)),
        };
        Parameter { name: name.to_owned(), ty, domain: Domain::Any, value: None }
    }
}

/// A row of the table of outputs.
#[derive(Debug)]
pub struct PartRow {
    /// The output.
    pub part: Part,
    /// Its field in the output struct.
    pub name: &'static str,
    /// Its title, a formula such as `dF/dX`.
    pub title: &'static str,
    /// The meaning of its rows.
    pub rows: Axis,
    /// The meaning of its columns; `None` for a list.
    pub columns: Option<Axis>,
    /// The extra arguments that it requires.
    pub extras: &'static [Extra],
    /// Whether only constraints have it.
    pub of_constraints: bool,
    /// Its description in the generated documentation.
    pub summary: &'static str,
}

/// All outputs, in the order of storage.
pub static PARTS: [PartRow; 18] = [
    PartRow {
        part: Part::Value,
        name: "value",
        title: "C",
        rows: Axis::Row,
        columns: None,
        extras: &[],
        of_constraints: false,
        summary: "the rows C of the constraint, or the energy E",
    },
    PartRow {
        part: Part::Rate,
        name: "rate",
        title: "dC/dt",
        rows: Axis::Row,
        columns: None,
        extras: &[],
        of_constraints: false,
        summary: "the rate of `value`, dC/dt or dE/dt",
    },
    PartRow {
        part: Part::Jacobian,
        name: "jacobian",
        title: "J",
        rows: Axis::Row,
        columns: Some(Axis::Coordinate),
        extras: &[],
        of_constraints: false,
        summary: "`jacobian[i][j]` is the derivative of `value[i]` along pose coordinate j",
    },
    PartRow {
        part: Part::Drift,
        name: "drift",
        title: "D(J V) V",
        rows: Axis::Row,
        columns: None,
        extras: &[],
        of_constraints: true,
        summary: "the second derivative of `value` in time at constant velocities: d^2C/dt^2 = J dV/dt + drift",
    },
    PartRow {
        part: Part::Multiplier,
        name: "multiplier",
        title: "lambda",
        rows: Axis::Row,
        columns: None,
        extras: &[],
        of_constraints: true,
        summary: "what each row of C pulls with: stiffness C + damping dC/dt, or zero where a one-sided row does nothing",
    },
    PartRow {
        part: Part::Force,
        name: "force",
        title: "F",
        rows: Axis::Coordinate,
        columns: None,
        extras: &[],
        of_constraints: false,
        summary: "generalised force F, in argument order",
    },
    PartRow {
        part: Part::Dfdx,
        name: "dfdx",
        title: "dF/dX",
        rows: Axis::Coordinate,
        columns: Some(Axis::Coordinate),
        extras: &[],
        of_constraints: false,
        summary: "`dfdx[i][j]` is the derivative of `force[i]` along pose coordinate j",
    },
    PartRow {
        part: Part::Dfdv,
        name: "dfdv",
        title: "dF/dV",
        rows: Axis::Coordinate,
        columns: Some(Axis::Coordinate),
        extras: &[],
        of_constraints: false,
        summary: "`dfdv[i][j]` is the derivative of `force[i]` by velocity coordinate j",
    },
    PartRow {
        part: Part::Impulse,
        name: "impulse",
        title: "h (F + h dF/dX V)",
        rows: Axis::Coordinate,
        columns: None,
        extras: &[Extra::Step],
        of_constraints: false,
        summary: "h (F + h dF/dX V), with h the `step`, in argument order",
    },
    PartRow {
        part: Part::Matrix,
        name: "matrix",
        title: "h dF/dV + h^2 dF/dX",
        rows: Axis::Coordinate,
        columns: Some(Axis::Coordinate),
        extras: &[Extra::Step],
        of_constraints: false,
        summary: "h dF/dV + h^2 dF/dX, with h the `step`",
    },
    PartRow {
        part: Part::MultiplierStep,
        name: "multiplier_step",
        title: "h dlambda/dV + h^2 dlambda/dX",
        rows: Axis::Row,
        columns: Some(Axis::Coordinate),
        extras: &[Extra::Step],
        of_constraints: true,
        summary: "h dlambda/dV + h^2 dlambda/dX, with h the `step`",
    },
    PartRow {
        part: Part::Held,
        name: "held_matrix",
        title: "h dF/dV + h^2 dF/dX, lambda given",
        rows: Axis::Coordinate,
        columns: Some(Axis::Coordinate),
        extras: &[Extra::Step, Extra::Multipliers],
        of_constraints: true,
        summary: "h dF/dV + h^2 dF/dX, with the `multipliers` for lambda where gradients of C turn",
    },
    PartRow {
        part: Part::Pull,
        name: "pull",
        title: "J^T lambda, lambda given",
        rows: Axis::Coordinate,
        columns: None,
        extras: &[Extra::Multipliers],
        of_constraints: true,
        summary: "J^T times the `multipliers`, in argument order; F is minus this for its own lambda",
    },
    PartRow {
        part: Part::Geometric,
        name: "geometric",
        title: "D(J^T) lambda, lambda given",
        rows: Axis::Coordinate,
        columns: Some(Axis::Coordinate),
        extras: &[Extra::Multipliers],
        of_constraints: true,
        summary: "`geometric[i][j]` is the derivative of `pull[i]` along pose coordinate j, the `multipliers` constant",
    },
    PartRow {
        part: Part::DfdxProduct,
        name: "dfdx_product",
        title: "dF/dX p",
        rows: Axis::Coordinate,
        columns: None,
        extras: &[Extra::Direction],
        of_constraints: false,
        summary: "dF/dX times the `direction`",
    },
    PartRow {
        part: Part::DfdvProduct,
        name: "dfdv_product",
        title: "dF/dV p",
        rows: Axis::Coordinate,
        columns: None,
        extras: &[Extra::Direction],
        of_constraints: false,
        summary: "dF/dV times the `direction`",
    },
    PartRow {
        part: Part::List(0),
        name: "list",
        title: "list",
        rows: Axis::Entry,
        columns: None,
        extras: &[],
        of_constraints: false,
        summary: "a list of entries of other results",
    },
    PartRow {
        part: Part::Block(0),
        name: "block",
        title: "block",
        rows: Axis::Entry,
        columns: Some(Axis::Entry),
        extras: &[],
        of_constraints: false,
        summary: "some rows and columns of another result",
    },
];

/// An output that a layout stores in place of others, or of a part of one. Names are those of the source.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Piece {
    /// A list with this number of entries of all outputs.
    Entries(usize),
    /// A block of rows, and of columns if there are any, of an output.
    Block {
        /// The output.
        part: Part,
        /// Its rows: those of a body, or all rows if they are not coordinates.
        rows: Range<usize>,
        /// Its columns: those of a body, or 0 .. 1 for a list.
        columns: Range<usize>,
        /// Names of the bodies that the rows and columns belong to.
        of: Vec<String>,
        /// Its name, unique among all blocks of the kernel.
        name: String,
    },
    /// The upper triangle of a symmetric matrix, row by row.
    Triangle(Part),
    /// Precomputed values, by name.
    Values(Vec<String>),
}

impl Piece {
    /// The name of the field that stores it.
    pub fn name(&self) -> String {
        match self {
            Piece::Entries(_) => "entries".to_owned(),
            Piece::Block { name, .. } => name.clone(),
            Piece::Triangle(part) => part.name().to_owned(),
            Piece::Values(_) => "prepared".to_owned(),
        }
    }

    /// Its description in the generated documentation.
    pub fn summary(&self) -> String {
        match self {
            Piece::Entries(_) => "each distinct entry of the results that is not zero, once".to_owned(),
            Piece::Block { part, of, .. } => match (of.as_slice(), part.row().rows) {
                ([], _) => part.row().summary.to_owned(),
                ([column], Axis::Row) => format!("{}, columns of `{column}`", part.title()),
                ([row], _) => format!("{}, rows of `{row}`", part.title()),
                (bodies, _) => {
                    format!("{}, rows of `{}`, columns of `{}`", part.title(), bodies[0], bodies[1])
                }
            },
            Piece::Triangle(part) => format!("{}, its upper triangle row by row", part.title()),
            Piece::Values(_) => "what is computed once".to_owned(),
        }
    }

    /// Its title for readers.
    pub fn title(&self) -> String {
        match self {
            Piece::Entries(_) => "entries".to_owned(),
            Piece::Block { part, of, .. } if !of.is_empty() => format!("{}: {}", part.title(), of.join(", ")),
            Piece::Block { part, .. } | Piece::Triangle(part) => part.title().to_owned(),
            Piece::Values(_) => "what is computed once".to_owned(),
        }
    }

    /// Numbers of rows and columns.
    fn shape(&self, signature: &Signature) -> (usize, usize) {
        match self {
            Piece::Entries(count) => (*count, 1),
            Piece::Values(names) => (names.len(), 1),
            Piece::Block { rows, columns, .. } => (rows.len(), columns.len()),
            Piece::Triangle(part) => {
                let (rows, _) = part.shape(signature);
                (rows * (rows + 1) / 2, 1)
            }
        }
    }
}

impl Part {
    /// The outputs that kernels compute by default.
    pub const DEFAULT: [Part; 3] = [Part::Force, Part::Dfdx, Part::Dfdv];

    /// The rows of the outputs that can be requested: all but those that a layout makes.
    pub fn choices() -> impl Iterator<Item = &'static PartRow> {
        PARTS.iter().filter(|row| row.rows != Axis::Entry)
    }

    /// The outputs with these names, in the order of the table; or the first unknown name.
    pub fn chosen<'n>(names: impl IntoIterator<Item = &'n str>) -> Result<Vec<Part>, &'n str> {
        let chosen = |name| Part::choices().find(|row| row.name == name).map(|row| row.part).ok_or(name);
        names.into_iter().map(chosen).collect::<Result<_, _>>().map(Part::in_order)
    }

    /// The extra arguments that these outputs require.
    pub fn extras(parts: &[Part]) -> Vec<Extra> {
        let mut extras: Vec<Extra> = parts.iter().flat_map(|part| part.row().extras).copied().collect();
        extras.sort_unstable();
        extras.dedup();
        extras
    }

    /// The same outputs in the order of the table, without duplicates.
    pub fn in_order(mut parts: Vec<Part>) -> Vec<Part> {
        parts.sort_unstable();
        parts.dedup();
        parts
    }

    /// The row of the output.
    pub fn row(self) -> &'static PartRow {
        let own = |row: &&PartRow| std::mem::discriminant(&row.part) == std::mem::discriminant(&self);
        PARTS.iter().find(own).expect("a result has a row")
    }

    /// The output that a layout made, if this is one.
    pub fn piece(self, signature: &Signature) -> Option<&Piece> {
        match self {
            Part::List(place) | Part::Block(place) => signature.pieces.get(place as usize),
            _ => None,
        }
    }

    /// Its field in the output struct.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Its title, a formula such as `dF/dX`.
    pub fn title(self) -> &'static str {
        self.row().title
    }

    /// Its name in the style of the source, in a kernel with this signature.
    pub fn stem(self, signature: &Signature) -> String {
        self.piece(signature).map_or_else(|| self.name().to_owned(), Piece::name)
    }

    /// Its description in a kernel with this signature.
    pub fn summary(self, signature: &Signature) -> String {
        self.piece(signature).map_or_else(|| self.row().summary.to_owned(), Piece::summary)
    }

    /// Its title in a kernel with this signature.
    pub fn titled(self, signature: &Signature) -> String {
        self.piece(signature).map_or_else(|| self.title().to_owned(), Piece::title)
    }

    /// Numbers of rows and columns; a list has one column.
    pub fn shape(self, signature: &Signature) -> (usize, usize) {
        if let Some(piece) = self.piece(signature) {
            return piece.shape(signature);
        }
        let length = |axis: Axis| match axis {
            Axis::Row => signature.rows,
            Axis::Coordinate => signature.dofs(),
            Axis::Entry => 0,
        };
        (length(self.row().rows), self.row().columns.map_or(1, length))
    }

    /// The body that a row of a matrix belongs to, if rows are coordinates of bodies.
    pub fn body_of_row(self, signature: &Signature, row: usize) -> Option<u16> {
        let table = self.row();
        if table.rows != Axis::Coordinate || table.columns.is_none() {
            return None;
        }
        let mut end = 0;
        let found = signature.moving().find(|(_, body)| {
            end += body.kind.dofs();
            row < end
        });
        found.map(|(body, _)| body as u16)
    }

    /// Number of entries.
    pub fn length(self, signature: &Signature) -> usize {
        let (rows, columns) = self.shape(signature);
        rows * columns
    }

    /// Whether the output is a list, not a matrix.
    pub fn is_list(self) -> bool {
        self.row().columns.is_none()
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One entry of an output.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Output {
    /// The output.
    pub part: Part,
    /// The row of the entry: for a force, the coordinate.
    pub row: usize,
    /// The column of the entry: the coordinate of differentiation; 0 in a list.
    pub column: usize,
}

impl Output {
    /// An entry, by output, row and column.
    pub fn new(part: Part, row: usize, column: usize) -> Output {
        Output { part, row, column }
    }

    /// The name in messages: `dfdx[a.ry][b.x]`, `jacobian[2][b.x]`.
    pub fn named(self, signature: &Signature) -> String {
        let column = self.column..self.column + 1;
        spans(self.part, &(self.row..self.row + 1), &[column], signature)
    }
}

/// The name of some rows and columns of an output in messages: `dfdx[a.x .. a.rz][b.x, b.z]`.
pub fn spans(part: Part, rows: &Range<usize>, columns: &[Range<usize>], signature: &Signature) -> String {
    // A block is a part of an output whose rows and columns have names.
    let (part, first, column) = match part.piece(signature) {
        Some(Piece::Block { part, rows, columns, .. }) => (*part, rows.start, columns.start),
        _ => (part, 0, 0),
    };
    let moved = |range: &Range<usize>, by: usize| range.start + by..range.end + by;
    let columns = part.row().columns.filter(|_| !columns.is_empty()).map_or_else(String::new, |axis| {
        let runs: Vec<String> =
            columns.iter().map(|run| span(axis, &moved(run, column), signature)).collect();
        format!("[{}]", runs.join(", "))
    });
    format!("{}[{}]{columns}", part.stem(signature), span(part.row().rows, &moved(rows, first), signature))
}

/// The name of some rows or columns of an output in messages: `a.x .. a.rz`, `0 .. 2`.
fn span(axis: Axis, range: &Range<usize>, signature: &Signature) -> String {
    let coordinates = signature.coordinate_names();
    let label = |index: usize| match axis {
        Axis::Row | Axis::Entry => index.to_string(),
        Axis::Coordinate => coordinates[index].clone(),
    };
    match range.len() {
        1 => label(range.start),
        _ => format!("{} .. {}", label(range.start), label(range.end - 1)),
    }
}

/// Entries of one output, row by row.
#[derive(Clone, PartialEq, Debug)]
pub struct Array<T> {
    /// The output.
    pub part: Part,
    /// Number of columns; 1 for a list.
    pub columns: usize,
    /// The entries, row by row.
    pub entries: Vec<T>,
}

/// Entries of an output, row by row; empty if `arrays` does not contain it.
pub fn entries<T>(arrays: &[Array<T>], part: Part) -> &[T] {
    arrays.iter().find(|array| array.part == part).map_or(&[], |array| &array.entries)
}

impl<T> Array<T> {
    /// Entries of an output in a kernel with this signature.
    pub fn new(part: Part, signature: &Signature, entries: Vec<T>) -> Array<T> {
        Array { part, columns: part.shape(signature).1, entries }
    }

    /// Entries with their positions.
    pub fn outputs(&self) -> impl Iterator<Item = (Output, &T)> {
        let (part, columns) = (self.part, self.columns.max(1));
        let place = move |(k, entry)| (Output::new(part, k / columns, k % columns), entry);
        self.entries.iter().enumerate().map(place)
    }

    /// The rows of entries.
    pub fn rows(&self) -> impl Iterator<Item = &[T]> {
        self.entries.chunks(self.columns.max(1))
    }
}
