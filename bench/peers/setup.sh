#!/usr/bin/env bash
# Installs the peers into a virtual environment, target/peers/venv, and writes their kernels into target/peers/kernels.
# Names of tools limit it to these: setup.sh casadi num_dual. Needs Python 3.11 or later and the network.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
place=${CARGO_TARGET_DIR:-$here/../../target}/peers
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --requirement "$here/requirements.txt"
mkdir -p "$place/kernels/include"
# SymForce's code needs Eigen, whose headers come with CasADi.
eigen=$("$place/venv/bin/python" -c 'import casadi, pathlib; print(pathlib.Path(casadi.__file__).parent)')/include/eigen3/Eigen
ln -sfn "$eigen" "$place/kernels/include/Eigen"
cd "$here"
for tool in "${@:-casadi wrenfold sympy symforce num_dual}"; do
    for name in $tool; do
        PYTHONDONTWRITEBYTECODE=1 "$place/venv/bin/python" "${name}_kernels.py" "$place/kernels"
    done
done
