"""Kernels by SymPy: expressions, `cse`, `ccode`. A newcomer prints what `cse` leaves; an expert has powers expanded and
the reciprocal root written as such, and prints named quantities in order."""

import sympy
from sympy.codegen.rewriting import create_expand_pow_optimization
from problems import PROBLEMS, Model, Tool, signature, write_all


class SymPy(Tool):
    def symbol(self, name):
        return sympy.Symbol(name, real=True)

    def is_simple(self, x):
        return isinstance(x, (int, float)) or x.is_Atom or (-x).is_Atom

    def jacobian(self, values, symbols):
        rows = []
        for value in values:
            free = getattr(value, "free_symbols", ())
            rows.append([number(value.diff(s)) if s in free else 0 for s in symbols])
        return rows

    def function(self, name, *arguments):
        return getattr(sympy, name)(*arguments)


def number(x):
    """Python's own integer where the entry is one."""
    return int(x) if x in (-1, 0, 1) else x


def generate(symbol, kernel, formulation):
    model = Model(SymPy(), PROBLEMS[kernel], formulation).kernel
    targets, values = ["out->force[%d]" % i for i in range(len(model.force))], list(model.force)
    for array, matrix in (("dfdx", model.dfdx), ("dfdv", model.dfdv)):
        for i, row in enumerate(matrix):
            targets += [f"out->{array}[{i}][{j}]" for j in range(len(row))]
            values += row
    named = model.named
    # `cse` may use a named quantity only below its definition: those go first, in order, and so do their parts.
    replaced, reduced = sympy.cse([v for _, v in named] + values, sympy.numbered_symbols("t"), optimizations=[])
    lines = [f"    const double {s} = {text};" for group in model.inputs for s, text in group]
    if formulation == "newcomer":
        show = sympy.ccode
    else:
        expand = create_expand_pow_optimization(4)
        show = lambda x: sympy.ccode(expand(sympy.sympify(x)))
    statements = [(s, x) for s, x in replaced] + [(s, x) for (s, _), x in zip(named, reduced)]
    lines += [f"    const double {s} = {show(x)};" for s, x in ordered(statements)]
    lines += [f"    {to} = {show(x)};" for to, x in zip(targets, reduced[len(named):])]
    return (
        f'#include <math.h>\n#include "{PROBLEMS[kernel].header}.h"\n\n'
        f"{signature(symbol, kernel)}\n{{\n" + "\n".join(lines) + "\n}\n"
    )


def ordered(statements):
    """The statements so that each stands below what it reads."""
    defined = dict(statements)
    done, result = set(), []
    for start, _ in statements:
        pending = [start]
        while pending:
            s = pending[-1]
            missing = [x for x in sorted(sympy.sympify(defined[s]).free_symbols, key=str)
                       if x in defined and x not in done]
            if s in done or not missing:
                pending.pop()
                if s not in done:
                    done.add(s)
                    result.append((s, defined[s]))
            else:
                pending += missing
    return result


if __name__ == "__main__":
    write_all("SymPy", sympy.__version__, generate)
