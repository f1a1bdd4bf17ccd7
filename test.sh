#!/usr/bin/env bash
# Installs what is missing, builds, runs every test.
#   ./test.sh                the release build
#   ./test.sh --sanitizers   and after it the unit tests under ASan and UBSan, and those with threads under TSan
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,4p' "$0" | cut -c3-; exit 0 ;; esac
cd "$(dirname "$(realpath "$0")")"
source cmake/install_packages.sh
need_packages build run scripts web test
jobs=$(nproc)

echo "== release"
cmake --preset release -DSKYQUILT_TESTS=ON >/dev/null
cmake --build --preset release -j "$jobs"
ctest --preset release -j "$jobs"
if [ "${1:-}" != --sanitizers ]; then exit 0; fi

# OpenCV, GDAL and TBB keep global memory until the end: leaks are looked for in the fuzzers, not here.
export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1
echo "== AddressSanitizer and UndefinedBehaviorSanitizer"
cmake --preset asan >/dev/null
cmake --build --preset asan -j "$jobs"
ctest --preset asan -j "$jobs" -LE "slow|web|e2e" -E "^Architecture"

echo "== ThreadSanitizer"
export TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp halt_on_error=1"
cmake --preset tsan >/dev/null
cmake --build --preset tsan -j "$jobs" --target skyquilt_concurrency_tests
ctest --preset tsan -j "$jobs" -L concurrency
