"""Kernels by dual numbers of num-dual, in Rust: `bench/dual`, built as a library, and a file in C for each kernel that
calls it. Nothing is generated, so that there is nothing to count."""

import pathlib
import re
import shutil
import subprocess
import sys

from problems import PROBLEMS, signature

ROOT = pathlib.Path(__file__).resolve().parents[2]


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    build = ["cargo", "rustc", "--release", "--quiet", "--package", "forcec-bench-dual", "--target-dir", folder / "dual"]
    subprocess.run([*build, "--", "-C", "target-cpu=native"], cwd=ROOT, check=True)
    shutil.copy(folder / "dual/release/libforcec_bench_dual.so", folder)
    version = re.search(r'name = "num-dual"\nversion = "(.*)"', (ROOT / "Cargo.lock").read_text())[1]
    for kernel, problem in PROBLEMS.items():
        symbol = f"num_dual_{kernel}"
        arguments = ", ".join([*(name for name, _ in problem.bodies), "params", "out"])
        declared = ", ".join(["const void *"] * (len(problem.bodies) + 1) + ["void *"])
        (folder / f"{symbol}.c").write_text(
            f'/* num-dual | {version} |  | {kernel} | - s */\n#include "{problem.header}.h"\n\n'
            f"void dual_{kernel}({declared});\n\n"
            f"{signature(symbol, kernel)}\n{{\n    dual_{kernel}({arguments});\n}}\n"
        )


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
