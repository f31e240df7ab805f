#!/bin/sh
# run.sh [SECONDS] [TARGET...]: feeds each reader of files, or those named, with damaged files for so long, by default 60 s.
# With build/fuzz (cmake --preset fuzz && cmake --build --preset fuzz) under libFuzzer and sanitizers, else with build/release.
seconds=${1:-60}
[ $# -gt 0 ] && shift
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
[ $# -gt 0 ] || set -- $(ls "$here/corpus")
failed=0
for target in "$@"; do
  if [ -x "$root/build/fuzz/bin/fuzz_guided" ]; then
    found=$(mktemp -d)
    TANDEM_FUZZ_TARGET=$target "$root/build/fuzz/bin/fuzz_guided" -max_total_time="$seconds" -timeout=1 -rss_limit_mb=512 \
      -max_len=65536 -print_final_stats=1 -artifact_prefix="fuzz-$target-" "$found" "$here/corpus/$target" >"$found.log" 2>&1 || failed=1
    echo "$target: $(grep -E 'stat::number_of_executed_units|stat::peak_rss_mb|ERROR|SUMMARY' "$found.log" | tr -s ' ' | tr '\n' ' ')"
    rm -rf "$found" "$found.log"
  else
    "$root/build/release/bin/fuzz_readers" "$target" "$seconds" "$(date +%s)" || failed=1
  fi
done
exit $failed
