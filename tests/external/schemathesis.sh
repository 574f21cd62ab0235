#!/usr/bin/env bash
# The service against its own contract: schemathesis makes requests from /openapi.json, good and bad ones, and compares
# every answer with what the contract says. One command, from anywhere:  tests/external/schemathesis.sh [tests per operation]
# It needs Python 3 with venv; what else it needs goes to target/external.
set -euo pipefail
cd "$(dirname "$0")/../.."
tools=$PWD/target/external/schemathesis
config=$PWD/tests/external/schemathesis.toml
if [ ! -x "$tools/bin/st" ]; then
    python3 -m venv "$tools"
    "$tools/bin/pip" install --quiet schemathesis==4.32.5
fi
cargo build --release --bin strahl

log=$(mktemp)
trap 'kill "$server" 2>/dev/null; rm -f "$log"' EXIT
# Small limits, so that no request takes long.
target/release/strahl serve --listen 127.0.0.1:0 --max-pixels 4096 --max-samples-total 100000 --max-body-bytes 1000000 \
    --timeout 5 2>"$log" &
server=$!
for _ in $(seq 100); do
    url=$(sed -n 's/.*listening on \(http:[^ ]*\)$/\1/p' "$log")
    [ -n "$url" ] && break
    sleep 0.1
done
# What it remembers goes to the folder it runs in.
cd "$tools"
"$tools/bin/st" --config-file "$config" run "$url/openapi.json" --checks all \
    --phases examples,coverage,fuzzing,stateful --max-examples "${1:-50}" --seed 1 --generation-deterministic \
    --request-timeout 10 --max-response-time 8
