#!/usr/bin/env bash
# Steps the robots of the simulation benchmarks in Rapier and in MuJoCo, and writes what they took and where they ended into
# target/peers/simulations, for `work-precision --peers`. Names limit it to these: simulations.sh rapier mujoco. Needs the
# network once; MuJoCo needs Python 3.11 or later, and is skipped where it cannot be installed.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
target=${CARGO_TARGET_DIR:-$here/../../target}
mkdir -p "$target/peers/simulations"
place=$(cd "$target/peers" && pwd)
# What engines log goes there too.
cd "$place"

rapier() {
    CARGO_TARGET_DIR="$place/rapier" cargo run --release --locked --manifest-path "$here/rapier/Cargo.toml" -- "$place/simulations"
}

mujoco() {
    [ -x venv/bin/python ] || python3 -m venv venv
    if ! venv/bin/pip install --quiet "$(grep '^mujoco==' "$here/requirements.txt")"; then
        echo "MuJoCo cannot be installed here, and is skipped" >&2
        return
    fi
    PYTHONDONTWRITEBYTECODE=1 venv/bin/python "$here/mujoco_robots.py" "$place/simulations"
}

for engine in "${@:-rapier mujoco}"; do
    for name in $engine; do
        "$name"
    done
done
