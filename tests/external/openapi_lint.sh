#!/usr/bin/env bash
# The contract as Redocly's linter sees it. One command, from anywhere:  tests/external/openapi_lint.sh
# It needs Node 20 or newer with npm; what else it needs goes to target/external.
set -euo pipefail
cd "$(dirname "$0")/../.."
tools=target/external/redocly
if [ ! -x "$tools/node_modules/.bin/redocly" ]; then
    mkdir -p "$tools"
    npm install --prefix "$tools" --silent --no-fund --no-audit @redocly/cli@2.77.0
fi
REDOCLY_TELEMETRY=off "$tools/node_modules/.bin/redocly" lint api/openapi.json --extends recommended
