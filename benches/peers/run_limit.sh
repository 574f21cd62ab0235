#!/bin/sh
# The limit for tiny scenes: run_limit.sh SCENE [THREADS]. Prints "TIME seconds".
cd "$(dirname "$0")/../../target/peers" || exit 1
exec ./w1_limit "$1.bin" "${2:-2}" 1
