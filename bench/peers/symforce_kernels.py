"""Kernels by SymForce, in C++ over Eigen: its own code generator, and an adapter from our structs. Matrices are written
in place and transposed, as Eigen stores columns, but for the newcomer, who copies them."""

import importlib.metadata
import pathlib
import tempfile

import symforce

symforce.set_epsilon_to_number(0.0)

import symforce.symbolic as sf
from symforce.codegen import Codegen, CppConfig
from symforce.codegen.codegen_config import RenderTemplateConfig, ZeroEpsilonBehavior
from symforce.values import Values

from problems import PROBLEMS, Model, Tool, signature, write_all


class SymForce(Tool):
    def __init__(self):
        self.count = 0

    def symbol(self, name):
        self.count += 1
        return sf.Symbol(f"{name}_{self.count}")

    def is_simple(self, x):
        return isinstance(x, int) or not sf.sympify(x).args or not (-x).args

    def jacobian(self, values, symbols):
        rows = []
        for value in values:
            free = getattr(value, "free_symbols", ())
            rows.append([number(value.diff(s)) if s in free else 0 for s in symbols])
        return rows

    def function(self, name, *arguments):
        return getattr(sf, name)(*arguments)


def number(x):
    """Python's own integer where the entry is one."""
    return int(x) if x in (-1, 0, 1) else x


def generate(symbol, kernel, formulation):
    problem = PROBLEMS[kernel]
    model = Model(SymForce(), problem, formulation).kernel
    names = [name for name, _ in problem.bodies] + ["params"]
    inputs = Values()
    for name, group in zip(names, model.inputs):
        inputs[name] = sf.Matrix([s for s, _ in group])
    known = {}
    for named, value in model.named:
        known[named] = sf.sympify(value).subs(known)
    newcomer = formulation == "newcomer"
    outputs = Values(force=sf.Matrix(model.force).subs(known))
    for name, rows in (("dfdx", model.dfdx), ("dfdv", model.dfdv)):
        matrix = sf.Matrix(rows).subs(known)
        outputs[name] = matrix if newcomer else matrix.T
    config = CppConfig(render_template_config=RenderTemplateConfig(autoformat=False),
                       zero_epsilon_behavior=ZeroEpsilonBehavior.ALLOW,
                       zero_initialization_sparsity_threshold=0.5 if newcomer else 1.0)
    function = Codegen(inputs, outputs, config, name=f"of_{symbol}")
    with tempfile.TemporaryDirectory() as folder:
        function.generate_function(output_dir=folder, skip_directory_nesting=True)
        text = next(pathlib.Path(folder).rglob(f"of_{symbol}.h")).read_text().replace("#pragma once", "")
    called = "".join(part.capitalize() for part in f"of_{symbol}".split("_"))
    n = len(model.force)
    sizes = [len(group) for group in model.inputs]
    arguments = ", ".join(
        f"*reinterpret_cast<const Eigen::Matrix<double, {size}, 1> *>({name})" for name, size in zip(names, sizes)
    )
    place = lambda part, columns: f"reinterpret_cast<Eigen::Matrix<double, {n}, {columns}> *>(out->{part})"
    if newcomer:
        call = (
            f"    Eigen::Matrix<double, {n}, {n}> dfdx, dfdv;\n"
            f"    sym::{called}<double>({arguments}, {place('force', 1)}, &dfdx, &dfdv);\n"
            f"    *{place('dfdx', n)} = dfdx.transpose();\n    *{place('dfdv', n)} = dfdv.transpose();\n"
        )
    else:
        call = f"    sym::{called}<double>({arguments}, {place('force', 1)}, {place('dfdx', n)}, {place('dfdv', n)});\n"
    # The structs are aligned to eight bytes.
    return (
        "#define EIGEN_MAX_ALIGN_BYTES 0\n#include <cmath>\n"
        f'extern "C" {{\n#include "{problem.header}.h"\n}}\n{text}\n'
        f'extern "C" {signature(symbol, kernel)}\n{{\n{call}}}\n'
    )


if __name__ == "__main__":
    write_all("SymForce", importlib.metadata.version("symforce"), generate, ending="cc")
