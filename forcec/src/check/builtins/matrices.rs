//! 3×3 matrices stored as three vectors, columns or rows, so that a matrix of vectors is used as vectors.

use crate::math::exact::Exact;
use crate::vector::{Graph, Real, Truth, Vector};

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Matrix3 {
    /// Three columns, or three rows.
    pub(crate) lines: [Vector; 3],
    /// Whether the lines are columns.
    pub(crate) columns: bool,
}

impl Matrix3 {
    pub(crate) fn columns(lines: [Vector; 3]) -> Matrix3 {
        Matrix3 { lines, columns: true }
    }

    pub(crate) fn rows(lines: [Vector; 3]) -> Matrix3 {
        Matrix3 { lines, columns: false }
    }

    pub(crate) fn transpose(self) -> Matrix3 {
        Matrix3 { columns: !self.columns, ..self }
    }
}

/// The entry at a row and column.
pub(crate) fn entry(g: &mut Graph, m: Matrix3, row: usize, column: usize) -> Real {
    if m.columns { g.component(m.lines[column], row as u8) } else { g.component(m.lines[row], column as u8) }
}

/// The same matrix, stored as columns or as rows.
pub(crate) fn turned(g: &mut Graph, m: Matrix3, columns: bool) -> Matrix3 {
    if m.columns == columns {
        return m;
    }
    let lines = [0, 1, 2].map(|k| {
        let entries = m.lines.map(|line| g.component(line, k));
        g.pack(entries)
    });
    Matrix3 { lines, columns }
}

/// The same matrix with one entry replaced.
pub(crate) fn replaced(g: &mut Graph, m: Matrix3, row: usize, column: usize, value: Real) -> Matrix3 {
    let (line, axis) = if m.columns { (column, row) } else { (row, column) };
    let mut entries = [0, 1, 2].map(|k| g.component(m.lines[line], k));
    entries[axis] = value;
    let mut lines = m.lines;
    lines[line] = g.pack(entries);
    Matrix3 { lines, ..m }
}

pub(crate) fn diagonal(g: &mut Graph, entries: [Real; 3]) -> Matrix3 {
    let zero = g.zero();
    Matrix3::columns([0, 1, 2].map(|k| {
        let mut column = [zero; 3];
        column[k] = entries[k];
        g.pack(column)
    }))
}

/// a A + b B
pub(crate) fn sum(g: &mut Graph, a: (Exact, Matrix3), b: (Exact, Matrix3)) -> Matrix3 {
    let other = turned(g, b.1, a.1.columns);
    let lines = std::array::from_fn(|k| {
        g.vector_sum(vec![(a.0.clone(), a.1.lines[k]), (b.0.clone(), other.lines[k])])
    });
    Matrix3 { lines, ..a.1 }
}

/// s A
pub(crate) fn scaled(g: &mut Graph, s: Real, m: Matrix3) -> Matrix3 {
    Matrix3 { lines: m.lines.map(|line| g.scale(s, line)), ..m }
}

/// A v
pub(crate) fn times_vector(g: &mut Graph, m: Matrix3, v: Vector) -> Vector {
    if m.columns {
        let terms = [0, 1, 2].map(|k| {
            let entry = g.component(v, k);
            (Exact::ONE, g.scale(entry, m.lines[k as usize]))
        });
        g.vector_sum(terms.into())
    } else {
        let entries = m.lines.map(|row| g.dot(row, v));
        g.pack(entries)
    }
}

/// A B; dot products if A is stored as rows and B as columns, else linear combinations of columns or rows.
pub(crate) fn product(g: &mut Graph, a: Matrix3, b: Matrix3) -> Matrix3 {
    match (a.columns, b.columns) {
        (true, true) => Matrix3::columns(b.lines.map(|column| times_vector(g, a, column))),
        (true, false) => {
            let b = turned(g, b, true);
            product(g, a, b)
        }
        (false, false) => {
            let transposed = b.transpose();
            Matrix3::rows(a.lines.map(|row| times_vector(g, transposed, row)))
        }
        (false, true) => Matrix3::columns(b.lines.map(|column| times_vector(g, a, column))),
    }
}

/// det A = a₀·(a₁×a₂) for columns or rows a
pub(crate) fn determinant(g: &mut Graph, m: Matrix3) -> Real {
    let cross = g.cross(m.lines[1], m.lines[2]);
    g.dot(m.lines[0], cross)
}

/// A⁻¹ and det A. For columns a, the rows of the inverse are a₁×a₂, a₂×a₀, a₀×a₁, each divided by det A.
pub(crate) fn inverse(g: &mut Graph, m: Matrix3) -> (Matrix3, Real) {
    let determinant = determinant(g, m);
    let lines = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
        let cross = g.cross(m.lines[i], m.lines[j]);
        g.quotient(cross, determinant)
    });
    (Matrix3 { lines, columns: !m.columns }, determinant)
}

pub(crate) fn trace(g: &mut Graph, m: Matrix3) -> Real {
    let terms = [0, 1, 2].map(|k| (Exact::ONE, g.component(m.lines[k as usize], k)));
    g.sum(Exact::ZERO, terms.into())
}

pub(crate) fn norm_squared(g: &mut Graph, m: Matrix3) -> Real {
    let terms = m.lines.map(|line| (Exact::ONE, g.dot(line, line)));
    g.sum(Exact::ZERO, terms.into())
}

/// u vᵀ
pub(crate) fn outer(g: &mut Graph, u: Vector, v: Vector) -> Matrix3 {
    Matrix3::columns([0, 1, 2].map(|k| {
        let entry = g.component(v, k);
        g.scale(entry, u)
    }))
}

/// A if the condition is true, else B
pub(crate) fn select(g: &mut Graph, condition: Truth, a: Matrix3, b: Matrix3) -> Matrix3 {
    let b = turned(g, b, a.columns);
    Matrix3 { lines: std::array::from_fn(|k| g.vector_select(condition, a.lines[k], b.lines[k])), ..a }
}
