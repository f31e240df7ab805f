#!/bin/bash
# nightly.sh [STEP...]: the checks that take too long for every change. Without steps it runs all of them, one after the other:
#
#   asan      all tests, whole peers and networks too, under the address and undefined-behaviour sanitizers
#   tsan      tests of several threads and of whole peers under the thread sanitizer
#   golden    golden hashes of the engine as clang compiles it
#   fuzz      each reader of files a minute under libFuzzer and sanitizers
#   ends      500 programs told to end at moments drawn at random
#   floods    floods of full size
#   networks  two machines in 96 arrangements of networks
#   soak      the endurance run, an hour
#   fidelity  contact beside exact surfaces, by the bars of docs/results
#   coverage  lines of code that the tests run through
#   mutation  small faults put into guards, checks of receivers and the wire: how many of them the tests find
#
# Each step prints one line or a few; the whole of it is in build/nightly/STEP.log. Exit code: 0 if no step failed. The last figures are in
# docs/results. JOBS=N compilers run at once (2).
cd "$(dirname "$0")/.." || exit 2
jobs=${JOBS:-2}
logs=$PWD/build/nightly
mkdir -p "$logs"

configure_and_build() { # PRESET [TARGET...]
  local preset=$1
  shift
  cmake --preset "$preset" && ninja -j "$jobs" -C "build/$preset" "$@"
}

# Programs write what sanitizers find to a file each, so that it is seen whatever a test does with a program's output. A handler of
# signals has a stack of its own, which the address sanitizer must not replace by its own. Peers that a sanitizer slows down may take
# all processors for themselves with real-time priority: they get none, so that others of a session are served too.
with_sanitizer() { # PRESET LABELS
  local reports=$logs/$1-reports
  configure_and_build "$1" || return 1
  rm -rf "$reports"
  mkdir -p "$reports"
  local ordinary=()
  [ "$(id -u)" != 0 ] || ordinary=(setpriv --bounding-set=-sys_nice --inh-caps=-sys_nice --)
  local common="log_path=$reports/report:exitcode=77"
  ASAN_OPTIONS="$common:detect_leaks=0:use_sigaltstack=0" UBSAN_OPTIONS="$common:print_stacktrace=1" \
    TSAN_OPTIONS="$common:suppressions=$PWD/tests/tsan.suppressions:second_deadlock_stack=1" \
    "${ordinary[@]}" ctest --test-dir "build/$1" --output-on-failure --timeout 900 -j 4 -L "$2"
  local status=$?
  echo "reports of sanitizers: $(find "$reports" -type f | wc -l)"
  [ $status -eq 0 ] && [ -z "$(ls "$reports")" ]
}

asan() { with_sanitizer asan 'unit|scenario|threads|network'; }
tsan() { with_sanitizer tsan 'threads|network'; }

golden() {
  cmake --preset clang -B build/golden -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_CLANG_TIDY= -DCMAKE_COMPILE_WARNING_AS_ERROR=OFF &&
    ninja -j "$jobs" -C build/golden world_test && build/golden/bin/world_test --gtest_filter='Golden*'
}

fuzz() { configure_and_build fuzz fuzz_guided && tests/fuzz/run.sh 60; }

ends() { configure_and_build release ends_test && TANDEM_ENDS=${TANDEM_ENDS:-500} build/release/bin/ends_test; }

floods() { configure_and_build release hostile_floods_test && TANDEM_FLOODS=1 build/release/bin/hostile_floods_test; }

networks() { configure_and_build release networks_test && TANDEM_ALL_NETWORKS=1 build/release/bin/networks_test; }

soak() {
  configure_and_build release soak_test &&
    TANDEM_SOAK_SECONDS=${TANDEM_SOAK_SECONDS:-3600} TANDEM_SOAK_RESULT=$logs/soak.json build/release/bin/soak_test --gtest_filter='Soak.*'
}

fidelity() {
  configure_and_build release program && build/release/bin/tandem bench fidelity --json >"$logs/fidelity.json" &&
    python3 tests/fidelity_bars.py "$logs/fidelity.json"
}

coverage() {
  configure_and_build coverage || return 1
  find build/coverage -name '*.gcda' -delete
  ctest --test-dir build/coverage -j 4 --timeout 900
  python3 tests/coverage.py build/coverage engine collab app
}

mutation() { python3 tests/mutation/mutate.py --count 100 --work build/mutation --jobs "$jobs" --json "$logs/mutation.json"; }

[ $# -gt 0 ] || set -- asan tsan golden fuzz ends floods networks soak fidelity coverage mutation
failed=0
for step in "$@"; do
  begun=$SECONDS
  "$step" >"$logs/$step.log" 2>&1
  status=$?
  [ $status -eq 0 ] && word=passed || { word=FAILED; failed=1; }
  echo "$step: $word, $((SECONDS - begun)) s, $(git rev-parse --short HEAD)"
  grep -E '(PASSED|FAILED)  \]|^[a-z0-9]+: .*stat::|tests passed|^reports of|were run$|were found|MISSED' "$logs/$step.log"
done
exit $failed
