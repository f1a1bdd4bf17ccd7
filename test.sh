#!/usr/bin/env bash
# Installs what is missing, builds, tests.
#   ./test.sh         the short suite, for every change: units, rules, each capability once from end to end
#   ./test.sh --all   everything: after it the long tests, the units under ASan and UBSan, those with threads under TSan,
#                     and each fuzz target for a minute; hours
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
ctest --preset long -j "$jobs"

# OpenCV, GDAL and TBB keep global memory until the end: leaks are looked for in the fuzzers, not here.
export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1
echo "== AddressSanitizer and UndefinedBehaviorSanitizer"
cmake --preset asan >/dev/null
cmake --build --preset asan -j "$jobs"
ctest --preset asan -j "$jobs" -LE "long|web|e2e" -E "^Architecture"

echo "== ThreadSanitizer"
export TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp halt_on_error=1"
cmake --preset tsan >/dev/null
cmake --build --preset tsan -j "$jobs" --target skyquilt_concurrency_tests
ctest --preset tsan -j "$jobs" -L concurrency -LE long

echo "== fuzz targets"
unset ASAN_OPTIONS
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz -j "$jobs"
for target in build/fuzz/bin/*_fuzz; do
  "$target" -max_total_time=60 -rss_limit_mb=4096 -artifact_prefix=build/fuzz/
done
