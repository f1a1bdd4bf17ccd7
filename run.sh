#!/usr/bin/env bash
# Skyquilt in one command: installs what is missing, builds, starts the server, makes a map, prints its address.
#   ./run.sh               the demo flight (simulated), served until Ctrl-C
#   ./run.sh PATH...       your own photos and logs (files or folders), served until Ctrl-C
#   ./run.sh --once [PATH...]   ends when the map is there
# Settings: SKYQUILT_LISTEN (default 127.0.0.1:8080, or a free port if that is taken), SKYQUILT_DATA_DIR (default: data beside this file)
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,6p' "$0" | cut -c3-; exit 0 ;; esac
once=false
if [ "${1:-}" = --once ]; then once=true; shift; fi
inputs=()
for path in "$@"; do inputs+=("$(realpath -e -- "$path")"); done
data=${SKYQUILT_DATA_DIR:+$(realpath -m -- "$SKYQUILT_DATA_DIR")}
cd "$(dirname "$(realpath "$0")")"

source cmake/install_packages.sh
need_packages build run scripts
# npm is 350 small packages: they come while the compiler runs.
need_packages web &
installing_npm=$!
cmake --preset release -DSKYQUILT_TESTS=OFF >/dev/null
cmake --build --preset release --target skyquilt
wait "$installing_npm"
cmake --build --preset release --target skyquilt_web
program=build/release/bin/skyquilt

data=${data:-$PWD/data}
mkdir -p "$data"
title="My flight"
if [ ${#inputs[@]} -eq 0 ]; then
  demo=build/demo_flight
  if [ ! -e "$demo/truth/poses.json" ]; then
    echo "Simulating the demo flight"
    "$program" simulate -o "$demo" --photos 24 --size 1600x1200 --height 60 --relief-m 3 --boxes --noise xmp \
      --exposure-jitter 0.06 --vignetting 0.15 --no-world --seed 7
  fi
  inputs=("$PWD/$demo/photos")
  title="Demo flight"
fi

listen=${SKYQUILT_LISTEN:-127.0.0.1:8080}
if (exec 3<>"/dev/tcp/${listen%:*}/${listen##*:}") 2>/dev/null; then listen=${listen%:*}:0; fi
log=$(mktemp)
"$program" serve --data "$data" --listen "$listen" > >(tee "$log") &
server=$!
finish() { kill -TERM "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; rm -f "$log"; }
trap finish EXIT
trap 'exit 130' INT TERM
url=
for _ in $(seq 100); do
  url=$(grep -oE 'http://[^ ]+' "$log" | head -1 || true)
  if [ -n "$url" ] && curl -fsS "${url%/}/healthz" >/dev/null 2>&1; then break; fi
  kill -0 "$server" || { echo "The server did not start." >&2; exit 1; }
  sleep 0.1
done
url=${url%/}

"$program" upload "${inputs[@]}" --server "$url" --name "$title" --patience 60
if $once; then exit 0; fi
echo "Ctrl-C ends the server."
wait "$server"
