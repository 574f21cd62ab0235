#!/bin/sh
# strahl on a scene: run_strahl.sh SCENE [THREADS [FLAGS]]. Prints "TIME seconds" of its trace phase.
cd "$(dirname "$0")/../../target/peers" || exit 1
../release/strahl render "$1.json" -o strahl.png --threads "${2:-2}" $3 --stats strahl.json || exit 1
python3 -c 'import json; print("TIME", json.load(open("strahl.json"))["cost"]["phases_ms"]["trace"] / 1000)'
