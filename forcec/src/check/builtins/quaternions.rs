//! Quaternions: a product of stored quaternions stays a chain until an entry is read; (p q)·v is p·(q·v).
//!
//! Storage order is x, y, z, w; with q = (u, w), q·v = v + 2w (u×v) + 2 u×(u×v). Angles are as in nalgebra.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::model::bodies::Slot;
use crate::vector::{Graph, Real, Truth, Vector};
use std::rc::Rc;

/// Longer products are multiplied out.
const LONGEST_CHAIN: usize = 8;

/// A unit quaternion.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Quaternion {
    /// The product of stored quaternions, each with whether it is inverted; the identity if empty.
    Chain(Rc<[(Slot, bool)]>),
    /// x, y, z, w
    Parts([Real; 4]),
}

impl Quaternion {
    /// The quaternion stored at a slot.
    pub(crate) fn stored(slot: Slot) -> Quaternion {
        Quaternion::Chain([(slot, false)].into())
    }

    pub(crate) fn identity() -> Quaternion {
        Quaternion::Chain([].into())
    }
}

/// x, y, z, w
pub(crate) fn parts(g: &mut Graph, q: &Quaternion) -> [Real; 4] {
    let chain = match q {
        Quaternion::Parts(parts) => return *parts,
        Quaternion::Chain(chain) => chain,
    };
    if g.simplifies() && !chain.is_empty() {
        let (u, w) = g.turn(chain);
        let [x, y, z] = [0, 1, 2].map(|axis| g.component(u, axis));
        return [x, y, z, w];
    }
    let mut product: Option<[Real; 4]> = None;
    for (slot, inverse) in chain.iter() {
        let mut factor = [0, 1, 2, 3].map(|offset| g.entry(Slot { offset: slot.offset + offset, ..*slot }));
        if *inverse {
            factor = conjugate_parts(g, factor);
        }
        product = Some(product.map_or(factor, |product| hamilton(g, product, factor)));
    }
    product.unwrap_or_else(|| {
        let (zero, one) = (g.zero(), g.one());
        [zero, zero, zero, one]
    })
}

/// u of (u, w)
pub(crate) fn imaginary(g: &mut Graph, q: &Quaternion) -> Vector {
    let [x, y, z, _] = parts(g, q);
    g.pack([x, y, z])
}

fn conjugate_parts(g: &mut Graph, [x, y, z, w]: [Real; 4]) -> [Real; 4] {
    [g.neg(x), g.neg(y), g.neg(z), w]
}

/// (u, w)(v, s) = (w v + s u + u×v, w s − u·v)
fn hamilton(g: &mut Graph, p: [Real; 4], q: [Real; 4]) -> [Real; 4] {
    // Row k: sign, entry of p and entry of q for each term of entry k, in nalgebra's order.
    const TERMS: [[(i64, usize, usize); 4]; 4] = [
        [(1, 3, 0), (1, 0, 3), (1, 1, 2), (-1, 2, 1)],
        [(1, 3, 1), (-1, 0, 2), (1, 1, 3), (1, 2, 0)],
        [(1, 3, 2), (1, 0, 1), (-1, 1, 0), (1, 2, 3)],
        [(1, 3, 3), (-1, 0, 0), (-1, 1, 1), (-1, 2, 2)],
    ];
    TERMS.map(|row| {
        let terms = row.map(|(sign, i, j)| (Exact::from(sign), g.mul(p[i], q[j])));
        g.sum(Exact::ZERO, terms.into())
    })
}

/// p q
pub(crate) fn product(g: &mut Graph, p: &Quaternion, q: &Quaternion) -> Quaternion {
    if let (Quaternion::Chain(p), Quaternion::Chain(q)) = (p, q)
        && (g.simplifies() && p.len() + q.len() <= LONGEST_CHAIN || p.is_empty() || q.is_empty())
    {
        return Quaternion::Chain(p.iter().chain(q.iter()).copied().collect());
    }
    let (p, q) = (parts(g, p), parts(g, q));
    Quaternion::Parts(hamilton(g, p, q))
}

/// q⁻¹, the conjugate of a unit quaternion
pub(crate) fn inverse(g: &mut Graph, q: &Quaternion) -> Quaternion {
    match q {
        Quaternion::Chain(chain) => {
            Quaternion::Chain(chain.iter().rev().map(|(slot, inverse)| (*slot, !inverse)).collect())
        }
        Quaternion::Parts(parts) => Quaternion::Parts(conjugate_parts(g, *parts)),
    }
}

/// q·v
pub(crate) fn rotate(g: &mut Graph, q: &Quaternion, v: Vector) -> Vector {
    match q {
        Quaternion::Chain(chain) => {
            chain.iter().rev().fold(v, |v, (slot, inverse)| g.rotate(*slot, *inverse, v))
        }
        Quaternion::Parts([x, y, z, w]) => {
            let u = g.pack([*x, *y, *z]);
            let t = g.cross(u, v);
            if !g.simplifies() {
                // ((2 u×v) w + u×(2 u×v)) + v, in nalgebra's order of operations.
                let two = g.constant(Exact::from(2));
                let t = g.scale(two, t);
                let (wt, ut) = (g.scale(*w, t), g.cross(u, t));
                let turned = g.vector_add(wt, ut);
                return g.vector_add(turned, v);
            }
            let (wt, ut) = (g.scale(*w, t), g.cross(u, t));
            let two = Exact::from(2);
            g.vector_sum(vec![(Exact::ONE, v), (two.clone(), wt), (two, ut)])
        }
    }
}

/// (sin(|v|/2) v/|v|, cos(|v|/2)); regular at v = 0, because it uses cos √s and its derivative at s = |v|²/4.
pub(crate) fn from_scaled_axis(g: &mut Graph, v: Vector) -> Quaternion {
    let square = g.dot(v, v);
    let s = g.scaled(Exact::ratio(1, 4), square);
    let w = g.call(Function::CosSqrt(0), &[s]);
    let derivative = g.call(Function::CosSqrt(1), &[s]);
    let factor = g.neg(derivative);
    let u = g.scale(factor, v);
    let [x, y, z] = [0, 1, 2].map(|axis| g.component(u, axis));
    Quaternion::Parts([x, y, z, w])
}

/// The angle 2 atan2(|u|, |w|), from 0 to π, and |u|.
pub(crate) fn angle(g: &mut Graph, q: &Quaternion) -> (Real, Real) {
    let [x, y, z, w] = parts(g, q);
    let u = g.pack([x, y, z]);
    let sine = g.norm(u);
    let cosine = g.call(Function::Abs, &[w]);
    let half = g.call(Function::Atan2, &[sine, cosine]);
    (g.scaled(Exact::from(2), half), sine)
}

/// Axis times angle, signum(w) 2 atan2(|u|, |w|)/|u| u; regular at u = 0.
pub(crate) fn scaled_axis(g: &mut Graph, q: &Quaternion) -> Vector {
    let [x, y, z, w] = parts(g, q);
    let u = g.pack([x, y, z]);
    let square = g.dot(u, u);
    let cosine = g.call(Function::Abs, &[w]);
    let ratio = g.call(Function::AngleRatio(0), &[square, cosine]);
    let sign = g.call(Function::Signum, &[w]);
    let factor = g.mul(sign, ratio);
    let factor = g.scaled(Exact::from(2), factor);
    g.scale(factor, u)
}

/// p if the condition is true, else q
pub(crate) fn select(g: &mut Graph, condition: Truth, p: &Quaternion, q: &Quaternion) -> Quaternion {
    if p == q {
        return p.clone();
    }
    let (p, q) = (parts(g, p), parts(g, q));
    Quaternion::Parts(std::array::from_fn(|k| g.select(condition, p[k], q[k])))
}
