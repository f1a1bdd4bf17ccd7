# Sourced by run.sh and test.sh: installs with apt what is missing, on Debian 12 or a kindred system.
# `need_packages build run` installs these sections of packages.txt; web only where there is no npm yet.

need_packages() {
  local section sections=() wanted missing=() package
  for section in "$@"; do
    if [ "$section" != web ] || ! command -v npm >/dev/null 2>&1; then sections+=("$section"); fi
  done
  if [ ${#sections[@]} -eq 0 ]; then return 0; fi
  wanted=$(cmake/list_packages.sh "${sections[@]}")
  for package in $wanted; do
    if [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then missing+=("$package"); fi
  done
  if [ ${#missing[@]} -eq 0 ]; then return 0; fi
  echo "Installing: ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then as_root=(sudo); fi
  if [ -z "${lists_are_new:-}" ]; then "${as_root[@]}" apt-get update -qq; lists_are_new=yes; fi
  DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
  # Tests start an nginx of their own: the package's is not to serve this machine.
  if [[ " ${missing[*]} " == *" nginx "* ]]; then
    "${as_root[@]}" service nginx stop >/dev/null 2>&1 || true
    "${as_root[@]}" update-rc.d nginx disable >/dev/null
  fi
}

# Compiled objects are found again from any clone.
export CCACHE_BASEDIR=$PWD
export CCACHE_NOHASHDIR=1
