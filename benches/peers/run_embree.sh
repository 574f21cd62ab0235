#!/bin/sh
# Our Whitted renderer on Embree: run_embree.sh SCENE hybrid|single|packet [THREADS]. Prints "TIME seconds".
cd "$(dirname "$0")/../../target/peers" || exit 1
exec ./embree_anchor "$1.bin" "${3:-2}" "$2"
