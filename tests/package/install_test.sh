#!/bin/bash
# install_test.sh SOURCE BUILD CXX: what `cmake --install` gives works, moved to another folder too: programs find their
# scenes, and a project builds with find_package(Tandem) alone.
set -euo pipefail
source "$(dirname "$0")/dead_links.sh"
source=$1 build=$2 compiler=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "FAULT: $*"; exit 1; }

cmake --install "$build" --prefix "$folder/first" >"$folder/log" || { cat "$folder/log"; fail "cmake --install failed"; }
prefix=$folder/moved
mv "$folder/first" "$prefix"
cd "$folder" # neither the source's nor the build's

dead=$(dead_links "$prefix/share/doc")
[[ ! $dead ]] || fail "links that lead nowhere: $dead"
[[ -f $prefix/share/doc/tandem/docs/using.md ]] || fail "the guide is not installed"
! grep -rlF -e "$source" -e "$build" "$prefix"/lib/*/cmake || fail "the CMake files name folders of this build"
version=$("$prefix/bin/tandem" --version)
"$prefix/bin/tandem" proximity peg_in_slot --json >scene.json || fail "the installed program has no peg_in_slot"
said=$("$prefix/bin/tandem" proximity no_such_scene 2>&1 || true)
[[ $said == *"bracket_actuator"*"$prefix/share/tandem/scenes"* ]] ||
  fail "the installed program looks for scenes elsewhere"

# the example, as it was installed
cp -r "$prefix/share/doc/tandem-dev/examples" example
cmake -S example -B built -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_COMPILER="$compiler" >>log || { cat log; fail "find_package(Tandem)"; }
cmake --build built >>log || { tail -60 log; fail "the example does not build"; }
built/one_frame example/press.json | tee forces
# The table's top is at 50 mm, the block's bottom at 55 mm, and contact begins 0.45 voxels of 1 mm earlier: the block stops
# within half a voxel of 4.55 mm. The hand's spring of 800 N/m is then stretched by what is left of the 10 mm.
awk 'NR == 2 && !($3 ^ 2 < 1e-6 && $4 == 0) { print "FAULT: a force before the block moves"; bad = 1 }
     { down = -$2; force = $3; contacts = $4 }
     END {
       if (NR != 12 || down < 4.05 || down > 5.05 || contacts < 4) { print "FAULT: the block does not stop on the table"; bad = 1 }
       expected = 0.8 * (10 - down)
       if (force < 0.99 * expected || force > 1.01 * expected) { print "FAULT: not", expected, "N"; bad = 1 }
       exit bad
     }' forces

# the example of a host: it attaches to the installed controller and lifts a block off the table
if [[ -x built/host_application ]]; then
  export XDG_RUNTIME_DIR=$folder/run
  mkdir -m 700 "$XDG_RUNTIME_DIR"
  "$prefix/bin/tandem" peer --session "package-$$" --interface lo --scene example/press.json \
    --control "package-$$" --brief </dev/null 2>controller &
  controller=$!
  for ((i = 0; i < 100; ++i)); do
    built/host_application "package-$$" block >lifted 2>refused && break
    sleep 0.1
  done
  kill $controller
  wait $controller || { cat controller; fail "the controller does not end well"; }
  # free space: the block follows by 20 mm, within 1 mm, and the spring is slack
  awk '{ if ($2 < 19 || $2 > 21 || $4 ^ 2 > 0.25 || $6 != 0) exit 1 }
       END { if (NR != 1) exit 1 }' lifted || { cat lifted refused controller; fail "the host does not lift the block"; }
fi

# the example of a driver: built against the interface that is installed, tried by the installed program
cp -r "$prefix/share/doc/tandem-dev/examples/device" device
cmake -S device -B driver -DCMAKE_PREFIX_PATH="$prefix" >>log || { tail log; fail "the driver's project"; }
cmake --build driver >>log || { tail -60 log; fail "the driver does not build"; }
PATH=$prefix/bin:$PATH ctest --test-dir driver --output-on-failure -V >tried || { cat tried; fail "the driver does not do"; }
grep 'circle: 2000 ticks' tried || { cat tried; fail "the driver was not timed"; }

# a component with a dependency of its own, and one that there is none of
if [[ -f $(echo "$prefix"/lib/*/cmake/Tandem/TandemDdsTargets.cmake) ]]; then
  mkdir network
  cat >network/CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(network LANGUAGES CXX)
find_package(Tandem 0.1 REQUIRED COMPONENTS engine dds)
find_package(Tandem QUIET COMPONENTS antigravity)
if(Tandem_FOUND)
  message(FATAL_ERROR "a component that does not exist was found")
endif()
add_executable(network network.cpp)
target_link_libraries(network PRIVATE tandem::dds)
END
  cat >network/network.cpp <<'END'
#include <tandem/collab/dds/transport/dds_transport.h>
#include <tandem/collab/dds/security/keys.h>
int main() { return tandem::LoadMemberKeys("/nonexistent") ? 1 : 0; }
END
  cmake -S network -B joined -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_COMPILER="$compiler" >>log || { tail log; fail "COMPONENTS dds"; }
  cmake --build joined >>log || { tail -60 log; fail "tandem::dds does not link"; }
  joined/network || fail "a program with tandem::dds does not run"
fi
echo "tandem $version installed, moved, used"
