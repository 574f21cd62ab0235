#!/bin/sh
# POV-Ray 3.7 on a scene: run_povray.sh SCENE [THREADS [ANTIALIASING]]. Prints "TIME seconds" of its trace phase.
cd "$(dirname "$0")/../../target/peers" || exit 1
# POV-Ray keeps its configuration in the home folder.
HOME=$PWD
export HOME
mkdir -p .povray/3.7
[ -f .povray/3.7/povray.conf ] || cp /etc/povray/3.7/povray.conf .povray/3.7/
# Width and height stand in the binary scene.
antialiasing=${3:--A}
set -- "$1" "${2:-2}" $(od -An -tu4 -j4 -N8 "$1.bin")
povray "+I$1.pov" "+W$3" "+H$4" "+WT$2" $antialiasing -D -V -F File_Gamma=sRGB 2>&1 |
    sed -n 's/.*Trace Time:.*(\([0-9.]*\) seconds).*/TIME \1/p'
