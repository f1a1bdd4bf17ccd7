#!/usr/bin/env bash
# Installs what is missing, builds, tests.
#   ./test.sh         the short suite, for every change: units, rules, each capability once from end to end
#   ./test.sh --all   everything: after it the long tests, units and server under ASan and UBSan, what has threads and a
#                     flight's whole way under TSan, and each fuzz target for half a minute; hours
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,5p' "$0" | cut -c3-; exit 0 ;; esac
cd "$(dirname "$(realpath "$0")")"
source cmake/install_packages.sh
need_packages build run scripts web test
jobs=$(nproc)

echo "== release"
cmake --preset release -DSKYQUILT_TESTS=ON >/dev/null
cmake --build --preset release -j "$jobs"
python3 tests/bench/proof.py --jobs $((jobs + 1))  # some wait for most of their time
if [ "${1:-}" != --all ]; then exit 0; fi

echo "== long tests"
need_packages long
python3 tests/e2e/npm_clients.py build/release/test_clients --native
cmake --preset release >/dev/null  # looks again for what was installed
failed=()  # what is said at the end: a test that fails does not hide what comes after it

timed() {  # says how long a command took
  local begun=$SECONDS
  "$@" || failed+=("$*")
  echo "== $((SECONDS - begun)) s: $*"
}

timed ctest --preset long -j $((jobs + 1))

echo "== AddressSanitizer and UndefinedBehaviorSanitizer: the units, and the server from end to end with its sandboxed processes"
cmake --preset asan >/dev/null
cmake --build --preset asan -j "$jobs"
timed ctest --preset asan -j $((jobs + 1)) -LE "long|web|e2e" -E "^Architecture"
timed ctest --preset asan -j $((jobs + 1)) -L "^server$" -LE cluster

echo "== ThreadSanitizer: what has threads, and a flight from its upload to its tiles"
cmake --preset tsan >/dev/null
cmake --build --preset tsan -j "$jobs" --target skyquilt_concurrency_tests
timed ctest --preset tsan -j "$jobs" -L concurrency -LE long

echo "== fuzz targets"
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz -j "$jobs"
fuzz() {  # one target for half a minute; what it says where it finds something, a line where it does not
  if "$1" -max_total_time=30 -rss_limit_mb=4096 -artifact_prefix=build/fuzz/ >"$1.log" 2>&1; then
    echo "$(basename "$1"): $(tail -n 1 "$1.log")"
  else
    tail -n 60 "$1.log" >&2
    return 1
  fi
}
export -f fuzz
timed xargs -0 -n 1 -P "$jobs" bash -c 'fuzz "$1"' _ < <(printf '%s\0' build/fuzz/bin/*_fuzz)

if [ ${#failed[@]} -gt 0 ]; then
  printf '== failed: %s\n' "${failed[@]}" >&2
  exit 1
fi
