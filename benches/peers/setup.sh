#!/bin/sh
# Sets up the other renderers: packages of Debian 12 (as root, or already there), Embree 4.4 out of a Python package, our
# two C++ programs, and the scenes. Everything but the packages lies in target/peers.
set -e
cd "$(dirname "$0")"
out="$(cd ../.. && pwd)/target/peers"
mkdir -p "$out"

if ! command -v povray >/dev/null || ! command -v g++ >/dev/null || ! python3 -c 'import ensurepip' 2>/dev/null; then
    apt-get update -q
    DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends povray povray-includes g++ python3-venv
fi
[ -d "$out/venv" ] || python3 -m venv "$out/venv"
"$out/venv/bin/pip" install -q embreex==4.4.0.post1 numpy

libraries=$(echo "$out"/venv/lib/python3*/site-packages/embreex.libs)
embree=$(basename "$libraries"/libembree4-*.so.4)
g++ -O3 -march=native -ffast-math -fno-finite-math-only -std=c++17 -pthread embree_anchor.cpp -o "$out/embree_anchor" \
    -L"$libraries" -l:"$embree" -Wl,-rpath,"$libraries" -Wl,-rpath-link,"$libraries"
g++ -O3 -march=native -ffast-math -mprefer-vector-width=512 -fopenmp-simd -std=c++17 -pthread w1_limit.cpp \
    -o "$out/w1_limit"

[ -f "$out/W4.json" ] || "$out/venv/bin/python" scenes.py "$out"
# The last line: whoever finds this file knows that all the rest is there.
touch "$out/ready"
