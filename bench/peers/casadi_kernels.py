"""Kernels by CasADi: one SX function, whose C is the tool's own. Dense results are transposed, as CasADi stores columns."""

import pathlib
import re
import tempfile

import casadi
from problems import PROBLEMS, Model, Tool, is_zero, signature, write_all


class CasADi(Tool):
    def symbol(self, name):
        return casadi.SX.sym(name)

    def is_simple(self, x):
        return isinstance(x, (int, float)) or x.is_symbolic() or x.is_constant() or (
            x.n_dep() == 1 and x.dep(0).is_symbolic() and casadi.is_equal(x, -x.dep(0), 1))

    def jacobian(self, values, symbols):
        matrix = casadi.jacobian(casadi.vertcat(*values), casadi.vertcat(*symbols))
        rows = [[0] * len(symbols) for _ in values]
        for i, j in zip(*matrix.sparsity().get_triplet()):
            rows[i][j] = number(matrix[i, j])
        return rows

    def function(self, name, *arguments):
        return getattr(casadi, name)(*arguments)


def number(x):
    """Python's own integer where the entry is one."""
    if x.is_constant() and float(x) in (-1.0, 0.0, 1.0):
        return int(float(x))
    return x


def generate(symbol, kernel, formulation):
    model = Model(CasADi(), PROBLEMS[kernel], formulation).kernel
    results = [casadi.vertcat(*model.force)]
    for matrix in (model.dfdx, model.dfdv):
        results.append(casadi.vertcat(*[casadi.horzcat(*row) for row in matrix]).T)
    results = [casadi.densify(casadi.SX(x)) for x in results]
    if model.named:
        symbols, values = zip(*model.named)
        shapes = [casadi.SX(v) for v in values]
        _, results = casadi.substitute_inplace(list(symbols), shapes, results, False)
    inputs = [casadi.vertcat(*[s for s, _ in group]) for group in model.inputs]
    function = casadi.Function(f"of_{symbol}", inputs, results, {"cse": formulation != "newcomer"})
    with tempfile.TemporaryDirectory() as folder:
        generator = casadi.CodeGenerator(f"{symbol}.c", {"with_header": False})
        generator.add(function)
        generator.generate(folder + "/")
        text = pathlib.Path(folder, f"{symbol}.c").read_text()
    names = [name for name, _ in PROBLEMS[kernel].bodies] + ["params"]
    arguments = ", ".join(f"(const double *){name}" for name in names)
    return (
        f'#include "{PROBLEMS[kernel].header}.h"\n{text}\n'
        f"{signature(symbol, kernel)}\n{{\n    const double *arguments[] = {{ {arguments} }};\n"
        "    double *results[] = { out->force, &out->dfdx[0][0], &out->dfdv[0][0] };\n"
        f"    of_{symbol}(arguments, results, 0, 0, 0);\n}}\n"
    )


if __name__ == "__main__":
    write_all("CasADi", casadi.__version__, generate)
