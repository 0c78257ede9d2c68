"""The problems of the comparison, written once for every tool.

In: a tool's arithmetic (`Tool`), a problem and a formulation. Out: a `Kernel`, expressions of the force and of its two
derivatives in the tool's own scalars. Definitions are those of `constraints/*.rs` and the language's contract: F stacks
force and torque of each body, in the world frame; a turn acts as q <- exp(dtheta/2) q.

Formulations:

- `newcomer`: the formula of F in stored coordinates, quaternions included; its Jacobian times that of the coordinates.
- `expert`: the options the tool has for speed, and rotated arms r = q v are symbols of their own, whose derivative is -[r]x.
- `chain`: every quantity that a person would name is a symbol with a row of derivatives, a Jacobian chain. One body's
  share follows from the others' because the forces are internal, and an energy's Hessian is symmetric.
"""

import argparse
import pathlib
import time
from dataclasses import dataclass, field

FORMULATIONS = ("newcomer", "expert", "chain")


class Tool:
    """What a tool must offer. Scalars have + - * / among each other and with numbers; zeros are Python's 0."""

    def symbol(self, name):
        """A new scalar unknown; the name is unique in the kernel."""
        raise NotImplementedError

    def jacobian(self, values, symbols):
        """Partial derivatives, a row for each value, with Python's 0 where there is none."""
        raise NotImplementedError

    def function(self, name, *arguments):
        """sqrt, log or atan2."""
        raise NotImplementedError


class V(tuple):
    """A vector."""

    def __add__(self, other):
        return V(x + y for x, y in zip(self, other))

    def __sub__(self, other):
        return V(x - y for x, y in zip(self, other))

    def __mul__(self, scale):
        return V(x * scale for x in self)


def dot(v, w):
    return total(times(x, y) for x, y in zip(v, w))


def cross(v, w):
    return V((v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]))


def is_zero(x):
    return isinstance(x, int) and x == 0


def is_one(x):
    return isinstance(x, int) and abs(x) == 1


def times(x, y):
    """A product that knows 0 and 1."""
    if is_zero(x) or is_zero(y):
        return 0
    if is_one(x):
        return y if x == 1 else -y
    if is_one(y):
        return x if y == 1 else -x
    return x * y


def total(terms):
    """A sum that knows 0."""
    terms = [x for x in terms if not is_zero(x)]
    result = terms[0] if terms else 0
    for x in terms[1:]:
        result = result + x
    return result


@dataclass
class Body:
    """What a problem reads of a body, and where its coordinates start among the degrees of freedom."""

    kind: str
    first: int
    position: V
    velocity: V
    orientation: V = None
    angular_velocity: V = None


@dataclass
class Kernel:
    """Expressions. `inputs`: a group for each argument, of (symbol, text in C). `named`: (symbol, expression) in order."""

    inputs: list = field(default_factory=list)
    named: list = field(default_factory=list)
    force: list = None
    dfdx: list = None
    dfdv: list = None


class Model:
    """Builds one kernel: makes symbols, and knows how each depends on the degrees of freedom."""

    def __init__(self, tool, problem, formulation):
        self.tool, self.formulation = tool, formulation
        self.kernel = Kernel()
        self.rows = {}  # by a symbol's place: its derivatives, {freedom: expression}
        self.symbols = []
        self.dofs = 0
        bodies = [self.body(name, kind) for name, kind in problem.bodies]
        group = []
        self.kernel.inputs.append(group)
        self.parameters = {name: self.read(group, f"params->{name}", shape) for name, shape in problem.parameters}
        if problem.rows:
            self.stiffness = self.read(group, "params->stiffness", ())
            self.damping = self.read(group, "params->damping", ())
        self.chained = formulation == "chain"
        # Translation: the position of the first body need not be differentiated by.
        self.active = [i for i in range(self.dofs) if not self.chained or i >= 3]
        result = problem.value(self, *bodies, *self.parameters.values())
        force = self.penalty(result, bodies) if problem.rows else self.gradient(result)
        self.derive(force, bodies, symmetric=not problem.rows)

    def read(self, group, text, shape):
        if not shape:
            symbol = self.tool.symbol(text.replace("->", "_").replace("[", "_").replace("]", ""))
            group.append((symbol, text))
            return symbol
        return V(self.read(group, f"{text}[{i}]", shape[1:]) for i in range(shape[0]))

    def body(self, name, kind):
        group, first = [], self.dofs
        self.kernel.inputs.append(group)
        position = self.read(group, f"{name}->position", (3,))
        for k in range(3):
            self.track(position[k], {first + k: 1})
        if kind == "particle":
            self.dofs += 3
            return Body(kind, first, position, self.read(group, f"{name}->velocity", (3,)))
        q = self.read(group, f"{name}->orientation", (4,))
        x, y, z, w = q
        # D_k q = e_k q / 2
        for entry, row in zip(q, ((w, z, -y), (-z, w, x), (y, -x, w), (-x, -y, -z))):
            self.track(entry, {first + 3 + k: row[k] * 0.5 for k in range(3)})
        self.dofs += 6
        velocity = self.read(group, f"{name}->velocity", (3,))
        return Body(kind, first, position, velocity, q, self.read(group, f"{name}->angular_velocity", (3,)))

    def track(self, symbol, row):
        self.symbols.append(symbol)
        self.rows[len(self.symbols) - 1] = row

    def name(self, name, value, row=None):
        """A symbol for a value where the formulation is a chain, with the row of its derivatives."""
        if isinstance(value, V):
            return V(self.name(f"{name}_{i}", x) for i, x in enumerate(value))
        if not self.chained or isinstance(value, int):
            return value
        row = row or dict(enumerate(self.differentiate([value])[0]))
        symbol = self.tool.symbol(name)
        self.kernel.named.append((symbol, value))
        row = {i: self.keep(f"d_{name}_{i}", x) for i, x in row.items() if i in self.active and not is_zero(x)}
        self.track(symbol, row)
        return symbol

    def keep(self, name, value):
        """A symbol for a derivative that occurs more than once; numbers and what is a symbol already stay."""
        if not self.chained or self.tool.is_simple(value):
            return value
        inner = self.differentiate([value])[0]
        symbol = self.tool.symbol(name)
        self.kernel.named.append((symbol, value))
        self.track(symbol, {i: x for i, x in enumerate(inner) if not is_zero(x)})
        return symbol

    def temporary(self, name, value):
        """A symbol for a value that is not differentiated again."""
        if not self.chained or self.tool.is_simple(value):
            return value
        symbol = self.tool.symbol(name)
        self.kernel.named.append((symbol, value))
        return symbol

    def rotate(self, name, body, v):
        """q v, with derivative -[q v]x where that is a symbol."""
        u, w = V(body.orientation[:3]), body.orientation[3]
        t = cross(u, v) * 2
        value = V(v) + t * w + cross(u, t)
        if self.formulation == "newcomer":
            return value
        r = V(self.tool.symbol(f"{name}_{k}") for k in range(3))
        for k, row in enumerate(((0, r[2], -r[1]), (-r[2], 0, r[0]), (r[1], -r[0], 0))):
            self.kernel.named.append((r[k], value[k]))
            self.track(r[k], {body.first + 3 + i: row[i] for i in range(3) if not is_zero(row[i])})
        return r

    def differentiate(self, values):
        """D of each value, a list over the degrees of freedom, by the chain rule over symbols."""
        partials = self.tool.jacobian(values, self.symbols)
        result = []
        for partial in partials:
            terms = [[] for _ in range(self.dofs)]
            for place, factor in enumerate(partial):
                if not is_zero(factor):
                    for i, x in self.rows[place].items():
                        if i in self.active:
                            terms[i].append(times(factor, x))
            result.append([total(t) for t in terms])
        return result

    def inverse(self, name, x):
        """1 / x, with D = -D x / x^2."""
        if not self.chained:
            return 1 / x
        row = self.differentiate([x])[0]
        symbol = self.tool.symbol(name)
        self.kernel.named.append((symbol, 1 / x))
        self.track(symbol, {i: -times(times(symbol, symbol), y) for i, y in enumerate(row) if not is_zero(y)})
        return symbol

    def log(self, name, x):
        value = self.tool.function("log", x)
        if not self.chained:
            return value
        inverse = self.inverse(f"inverse_{name}", x)
        return self.name(name, value, {i: times(y, inverse) for i, y in enumerate(self.differentiate([x])[0])})

    def atan2(self, name, y, x):
        value = self.tool.function("atan2", y, x)
        if not self.chained:
            return value
        inverse = self.inverse(f"inverse_{name}", x * x + y * y)
        dy, dx = self.differentiate([y, x])
        row = [times(total((times(x, p), times(-1, times(y, q)))), inverse) for p, q in zip(dy, dx)]
        return self.name(name, value, dict(enumerate(row)))

    def norm(self, name, v):
        """|v|, with D |v| = n·D v and D n = (D v - n (n·D v)) / |v|, n the direction."""
        length = self.tool.function("sqrt", dot(v, v))
        if not self.chained:
            return length
        columns = self.differentiate(list(v))
        symbol, inverse = self.tool.symbol(name), self.tool.symbol(f"inverse_{name}")
        n = V(self.tool.symbol(f"n_{name}_{k}") for k in range(3))
        self.kernel.named += [(symbol, length), (inverse, 1 / symbol), *((n[k], v[k] * inverse) for k in range(3))]
        row = [total(times(n[k], columns[k][i]) for k in range(3)) for i in range(self.dofs)]
        held = {i: self.temporary(f"d_{name}_{i}", row[i]) for i in self.active if not is_zero(row[i])}
        for k in range(3):
            self.track(n[k], {i: times(total((columns[k][i], -times(n[k], x))), inverse) for i, x in held.items()})
        self.track(symbol, held)
        self.track(inverse, {i: -times(times(inverse, inverse), x) for i, x in held.items()})
        for i, x in held.items():
            if x is not row[i]:
                self.track(x, {j: y for j, y in enumerate(self.differentiate([row[i]])[0]) if not is_zero(y)})
        return symbol

    def penalty(self, rows, bodies):
        """F = -J^T (ks C + kd J V)."""
        velocity = [x for body in bodies for x in (*body.velocity, *(body.angular_velocity or ()))]
        jacobian = self.differentiate(rows)
        jacobian = [[self.keep(f"j_{r}_{i}", x) for i, x in enumerate(row)] for r, row in enumerate(jacobian)]
        if self.chained:
            # In place of the first body's velocity, the others' against it.
            for first in [body.first for body in bodies[1:]]:
                for k in range(3):
                    velocity[first + k] = self.temporary(f"u_{first + k}", velocity[first + k] - velocity[k])
        tension = []
        for r, (row, c) in enumerate(zip(jacobian, rows)):
            rate = total(times(x, v) for x, v in zip(row, velocity))
            tension.append(self.name(f"tension_{r}", self.stiffness * c + self.damping * rate))
        force = []
        for i in range(self.dofs):
            terms = (times(row[i], t) for row, t in zip(jacobian, tension))
            force.append(total(-x for x in terms if not is_zero(x)))
        self.jacobian = jacobian
        return force

    def gradient(self, energy):
        """F = -D E."""
        return [-x if not is_zero(x) else 0 for x in self.differentiate([energy])[0]]

    def derive(self, force, bodies, symmetric):
        n = self.dofs
        dfdx = self.differentiate(force)
        dfdv = [[0] * n for _ in range(n)]
        if not symmetric:
            for i in range(n):
                for j in range(n):
                    entry = total(times(row[i], row[j]) for row in self.jacobian)
                    dfdv[i][j] = times(-self.damping, entry) if not is_zero(entry) else 0
        if self.chained:
            for i in self.active:
                for j in self.active:
                    dfdv[i][j] = self.temporary(f"dfdv_{i}_{j}", dfdv[i][j]) if i <= j else dfdv[j][i]
                    if symmetric and j < i:
                        dfdx[i][j] = dfdx[j][i]
                    dfdx[i][j] = self.temporary(f"dfdx_{i}_{j}", dfdx[i][j])
                force[i] = self.temporary(f"f_{i}", force[i])
            others = [body.first for body in bodies[1:]]
            opposite = lambda terms: total(times(-1, x) for x in terms)
            for k in range(3):
                force[k] = opposite(force[f + k] for f in others)
                for matrix in (dfdx, dfdv):
                    for i in self.active:
                        matrix[i][k] = opposite(matrix[i][f + k] for f in others)
            for matrix in (dfdx, dfdv):
                for k in range(3):
                    matrix[k] = [opposite(matrix[f + k][j] for f in others) for j in range(n)]
        self.kernel.force, self.kernel.dfdx, self.kernel.dfdv = force, dfdx, dfdv


def gap(m, a, b, arm_a, arm_b):
    d = m.name("d", b.position - a.position)
    return d + m.rotate("rb", b, arm_b) - m.rotate("ra", a, arm_a)


def point_to_point(m, a, b, arm_a, arm_b):
    return list(gap(m, a, b, arm_a, arm_b))


def distance(m, a, b, arm_a, arm_b, rest_length):
    return [m.norm("length", m.name("gap", gap(m, a, b, arm_a, arm_b))) - rest_length]


def hinge(m, a, b, arm_a, arm_b, axis_a, normal_b1, normal_b2):
    axis = m.rotate("axis", a, axis_a)
    n1, n2 = m.rotate("n1", b, normal_b1), m.rotate("n2", b, normal_b2)
    return [*gap(m, a, b, arm_a, arm_b), dot(axis, n1), dot(axis, n2)]


def spring(m, p0, p1, rest_length):
    return [m.norm("length", m.name("d", p1.position - p0.position)) - rest_length]


def edges(m, p0, *others):
    return [m.name(f"e{i}", p.position - p0.position) for i, p in enumerate(others, 1)]


def neo_hookean(m, p0, p1, p2, p3, inverse_rest, volume, mu, lambda_):
    e = edges(m, p0, p1, p2, p3)
    f = [m.name(f"f{c}", e[0] * inverse_rest[0][c] + e[1] * inverse_rest[1][c] + e[2] * inverse_rest[2][c])
         for c in range(3)]
    stretch = sum(dot(column, column) for column in f)
    log_j = m.log("log_j", m.name("j", dot(f[0], m.name("k", cross(f[1], f[2])))))
    return volume * (0.5 * mu * (stretch - 3) - mu * log_j + 0.5 * lambda_ * log_j * log_j)


def dihedral(m, p0, p1, p2, p3, stiffness, rest_angle):
    edge, side_a, side_b = edges(m, p0, p1, p2, p3)
    na, nb = m.name("na", cross(edge, side_a)), m.name("nb", cross(side_b, edge))
    y = m.name("y", m.norm("length", edge) * dot(side_b, na))
    turn = m.atan2("angle", y, m.name("x", dot(na, nb))) - rest_angle
    return 0.5 * stiffness * turn * turn


def stvk_triangle(m, p0, p1, p2, inverse_rest, area, mu, lambda_):
    e1, e2 = edges(m, p0, p1, p2)
    wu = m.name("wu", e1 * inverse_rest[0][0] + e2 * inverse_rest[1][0])
    wv = m.name("wv", e1 * inverse_rest[0][1] + e2 * inverse_rest[1][1])
    uu = m.name("uu", 0.5 * (dot(wu, wu) - 1))
    vv = m.name("vv", 0.5 * (dot(wv, wv) - 1))
    uv = m.name("uv", 0.5 * dot(wu, wv))
    trace = uu + vv
    return area * (mu * (uu * uu + vv * vv + 2 * uv * uv) + 0.5 * lambda_ * trace * trace)


@dataclass
class Problem:
    """A kernel of the library: its file, its bodies and parameters with their shapes, whether its value is the rows of a
    constraint (else an energy), and the value."""

    header: str
    bodies: list
    parameters: list
    rows: bool
    value: object


def particles(count):
    return [(f"p{i}", "particle") for i in range(count)]


RIGID = [("a", "rigid"), ("b", "rigid")]
ARMS = [("arm_a", (3,)), ("arm_b", (3,))]
HINGE = [("axis_a", (3,)), ("normal_b1", (3,)), ("normal_b2", (3,))]
LAME = [("mu", ()), ("lambda", ())]

PROBLEMS = {
    "point_to_point": Problem("joints", RIGID, ARMS, True, point_to_point),
    "distance": Problem("joints", RIGID, [*ARMS, ("rest_length", ())], True, distance),
    "hinge": Problem("joints", RIGID, [*ARMS, *HINGE], True, hinge),
    "spring": Problem("springs", particles(2), [("rest_length", ())], True, spring),
    "neo_hookean": Problem(
        "solids", particles(4), [("inverse_rest", (3, 3)), ("volume", ()), *LAME], False, neo_hookean
    ),
    "dihedral": Problem("cloth", particles(4), [("stiffness", ()), ("rest_angle", ())], False, dihedral),
    "stvk_triangle": Problem(
        "cloth", particles(3), [("inverse_rest", (2, 2)), ("area", ()), *LAME], False, stvk_triangle
    ),
}


def signature(symbol, kernel):
    """The head of the function that the driver calls: the interface of the emitted C."""
    problem = PROBLEMS[kernel]
    bodies = "".join(f"const forcec_{kind}_f64 *{name}, " for name, kind in problem.bodies)
    return f"void {symbol}({bodies}const {kernel}_params_f64 *params, {kernel}_out_f64 *out)"


def write_all(tool, version, generate, ending="c", formulations=FORMULATIONS):
    """A tool's command line: FOLDER [KERNEL ...] [--formulation NAME ...]. `generate(symbol, kernel, formulation)` returns the text of a file."""
    parser = argparse.ArgumentParser(description=f"kernels by {tool}")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("kernels", nargs="*")
    parser.add_argument("--formulation", choices=formulations, action="append")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for kernel in options.kernels or PROBLEMS:
        for formulation in options.formulation or formulations:
            symbol = f"{tool.lower()}_{formulation}_{kernel}"
            start = time.perf_counter()
            text = generate(symbol, kernel, formulation)
            seconds = time.perf_counter() - start
            head = f"/* {tool} | {version} | {formulation} | {kernel} | {seconds:.3f} s */\n"
            (options.folder / f"{symbol}.{ending}").write_text(head + text)
            print(f"{symbol}: {seconds:.2f} s", flush=True)
