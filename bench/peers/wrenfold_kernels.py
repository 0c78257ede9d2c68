"""Kernels by wrenfold, in C++. Arguments are spans over the structs' memory, whose few lines stand here because the tool's
own header is not in its package. In a chain, named quantities are `unevaluated`, the tool's way to keep them together."""

import importlib.metadata
from typing import Annotated

import wrenfold as wf
from wrenfold import sym
from wrenfold.enumerations import NumberSet
from problems import PROBLEMS, Model, Tool, signature, write_all

SPAN = """
namespace wf {
template <int Rows, int Columns, typename T> struct span {
    T *data;
    T &operator()(int row, int column) const { return data[row * Columns + column]; }
};
template <int Rows, int Columns> span<Rows, Columns, const double> make_input_span(const double *data) { return { data }; }
template <int Rows, int Columns> span<Rows, Columns, double> make_output_span(double *data) { return { data }; }
}
"""


class Wrenfold(Tool):
    """The tool makes the inputs itself: they wait in `given`."""

    def __init__(self, given):
        self.given, self.count = list(given), 0

    def symbol(self, name):
        if self.given:
            return self.given.pop(0)
        self.count += 1
        return sym.symbol(f"{name}_{self.count}", NumberSet.Real)

    def is_simple(self, x):
        return isinstance(x, int) or (len(x.args) == 0) or len((-x).args) == 0

    def jacobian(self, values, symbols):
        values = [sym.integer(v) if isinstance(v, int) else v for v in values]
        matrix = sym.jacobian(values, symbols)
        return [[number(matrix[i, j]) for j in range(len(symbols))] for i in range(len(values))]

    def function(self, name, *arguments):
        return getattr(sym, name)(*arguments)


NUMBERS = {1: sym.one, 0: sym.zero, -1: sym.integer(-1)}


def number(x):
    """Python's own integer where the entry is one."""
    return next((n for n, e in NUMBERS.items() if x.is_identical_to(e)), x)


def shape(rows, columns=1):
    return Annotated[sym.MatrixExpr, wf.Shape(rows=rows, cols=columns)]


def length(dimensions):
    return 1 if not dimensions else dimensions[0] * length(dimensions[1:])


def generate(symbol, kernel, formulation):
    problem = PROBLEMS[kernel]
    sizes = {name: 13 if kind == "rigid" else 6 for name, kind in problem.bodies}
    sizes["params"] = sum(length(s) for _, s in problem.parameters) + 2 * problem.rows

    def function(**arguments):
        given = [matrix[i, 0] for name, matrix in arguments.items() for i in range(sizes[name])]
        model = Model(Wrenfold(given), problem, formulation).kernel
        known = []
        for named, value in model.named:
            value = value.subs(known) if known else value
            known.append((named, sym.unevaluated(value) if formulation == "chain" else value))
        outputs = []
        for name, rows in (("force", [[x] for x in model.force]), ("dfdx", model.dfdx), ("dfdv", model.dfdv)):
            matrix = sym.matrix(rows)
            outputs.append(wf.OutputArg(matrix.subs(known) if known else matrix, name))
        return outputs

    function.__annotations__ = {name: shape(size) for name, size in sizes.items()}
    text = generated(function, f"of_{symbol}", list(sizes), formulation)
    arguments = ", ".join(f"reinterpret_cast<const double *>({name})" for name in sizes)
    return (
        f'#include <cmath>\nextern "C" {{\n#include "{problem.header}.h"\n}}\n{SPAN}\n{text}\n'
        f'extern "C" {signature(symbol, kernel)}\n{{\n'
        f"    of_{symbol}<double>({arguments}, out->force, out->dfdx[0], out->dfdv[0]);\n}}\n"
    )


def generated(function, name, names, formulation):
    """The tool's text. It asks for a signature, which has the problem's arguments."""
    import inspect

    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    parameters = [inspect.Parameter(n, kind, annotation=function.__annotations__[n]) for n in names]
    function.__signature__ = inspect.Signature(parameters)
    options = wf.OptimizationParams()
    if formulation != "newcomer":
        options.factorization_passes = 3
    return wf.generate_function(function, wf.CppGenerator(), name=name, optimization_params=options)


if __name__ == "__main__":
    write_all("wrenfold", importlib.metadata.version("wrenfold"), generate, ending="cc")
