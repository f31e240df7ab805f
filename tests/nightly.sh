#!/bin/bash
# nightly.sh [STEP...]: the checks that take too long for every change. Without steps it runs all of them, one after the other:
#
#   fuzz      each reader of files a minute under libFuzzer and sanitizers
#   ends      500 programs told to end at moments drawn at random
#   floods    floods of full size
#   soak      the endurance run, an hour
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

fuzz() { configure_and_build fuzz fuzz_guided && tests/fuzz/run.sh 60; }

ends() { configure_and_build release ends_test && TANDEM_ENDS=${TANDEM_ENDS:-500} build/release/bin/ends_test; }

floods() { configure_and_build release hostile_floods_test && TANDEM_FLOODS=1 build/release/bin/hostile_floods_test; }

soak() {
  configure_and_build release soak_test &&
    TANDEM_SOAK_SECONDS=${TANDEM_SOAK_SECONDS:-3600} TANDEM_SOAK_RESULT=$logs/soak.json build/release/bin/soak_test --gtest_filter='Soak.*'
}

[ $# -gt 0 ] || set -- fuzz ends floods soak
failed=0
for step in "$@"; do
  begun=$SECONDS
  "$step" >"$logs/$step.log" 2>&1
  status=$?
  [ $status -eq 0 ] && word=passed || { word=FAILED; failed=1; }
  echo "$step: $word, $((SECONDS - begun)) s, $(git rev-parse --short HEAD)"
  grep -E '(PASSED|FAILED)  \]|^[a-z0-9]+: .*stat::' "$logs/$step.log"
done
exit $failed
