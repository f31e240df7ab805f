#!/bin/bash
# options_test.sh SOURCE BUILD: without Qt, Cyclone DDS, CLI11 and GoogleTest the engine and a peer's library are there to
# build, each file by the same command as in BUILD, which built them; without Qt all but the window is there to build.
set -euo pipefail
source=$1 build=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "FAULT: $*"; exit 1; }

configure() { # name, options...
  cmake -G Ninja -S "$source" -B "$folder/$1" -DCMAKE_EXPORT_COMPILE_COMMANDS=ON "${@:2}" >"$folder/$1.log" 2>&1 ||
    { cat "$folder/$1.log"; fail "$1: CMake"; }
  ninja -C "$folder/$1" -t targets all >"$folder/$1.targets"
}
without() { printf -- '-DCMAKE_DISABLE_FIND_PACKAGE_%s=ON\n' "$@"; }
has() { grep -q "$2: " "$folder/$1.targets" || fail "$1: nothing makes $2"; }
has_no() { ! grep -E "$2" "$folder/$1.targets" || fail "$1: it has $2"; }
setting() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"; }
# the files of a build, each with its definitions, folders of headers and language, and what a unit of several files has
commands() {
  sed -n 's/^ *"command": "\(.*\)",$/\1/p' "$1/compile_commands.json" | sed "s|\\\\\"|\"|g; s|$1|BUILD|g" |
    awk '{ line = $NF
           for (i = 1; i < NF; ++i) {
             if ($i ~ /^-(D|I|std=)/) line = line " " $i
             if ($i == "-isystem") line = line " " $i " " $(i + 1)
           }
           print line }'
  (cd "$1" && find . -path '*/Unity/*.cxx' -exec grep -H '^#include "' {} +)
}

configure engine -DTANDEM_BUILD_DDS=OFF -DCMAKE_UNITY_BUILD="$(setting CMAKE_UNITY_BUILD)" \
  -DCMAKE_UNITY_BUILD_BATCH_SIZE="$(setting CMAKE_UNITY_BUILD_BATCH_SIZE)" $(without Qt6 CycloneDDS CLI11 GTest)
has engine libtandem_world.a
has engine libtandem_haptics.a
has engine libtandem_collab.a
has_no engine '(bin/|/)tandem(-view|-bench)?: |libtandem_(dds|idl)|(^|/)app/'
commands "$folder/engine" | sort >"$folder/alone"
commands "$build" | sort >"$folder/whole"
[[ $(grep -c '^BUILD\|^/' "$folder/alone") -ge 40 ]] || { cat "$folder/alone"; fail "engine: too few files are compiled"; }
comm -23 "$folder/alone" "$folder/whole" >"$folder/others"
[[ ! -s $folder/others ]] || { cat "$folder/others"; fail "engine: files are compiled otherwise than beside the application"; }
grep -q '^CMAKE_BUILD_TYPE:STRING=Release$' "$folder/engine/CMakeCache.txt" || fail "the default build is no Release"

configure windowless -DTANDEM_BUILD_VIEWER=OFF $(without Qt6 GTest)
has windowless bin/tandem
has windowless bin/tandem-bench
has_no windowless 'tandem-view'

# as a part of another project: no tests, no warnings of ours, the names and the headers of an installation
mkdir "$folder/outer"
cat >"$folder/outer/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.25)
project(outer LANGUAGES C CXX)
set(TANDEM_BUILD_DDS OFF)
add_subdirectory($source tandem)
add_executable(one_frame $source/docs/examples/one_frame.cpp)
target_link_libraries(one_frame PRIVATE tandem::world)
END
cmake -G Ninja -S "$folder/outer" -B "$folder/inner" -DCMAKE_EXPORT_COMPILE_COMMANDS=ON $(without Qt6 CycloneDDS CLI11 GTest) \
  >"$folder/inner.log" 2>&1 || { cat "$folder/inner.log"; fail "as a part of another project"; }
! grep -e -Wshadow "$folder/inner/compile_commands.json" || fail "another project gets our warnings"
object=$(ninja -C "$folder/inner" -t targets all | sed -n 's/^\(.*one_frame.cpp.o\): .*/\1/p')
ninja -C "$folder/inner" "$object" >"$folder/inner.log" || { cat "$folder/inner.log"; fail "the headers"; }

# what is missed is named
! cmake -G Ninja -S "$source" -B "$folder/missing" $(without CycloneDDS) >"$folder/missing.log" 2>&1 || fail "configured without DDS"
grep -q CycloneDDS "$folder/missing.log" || fail "CMake does not say that Cyclone DDS is missing"
echo "the engine alone: as beside the application; all but the window: configured"
