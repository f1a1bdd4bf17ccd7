# Sourced by run.sh and test.sh: installs with apt what is missing, on Debian 12 or a kindred system.
# `need_packages build` for building and running, `need_packages test` for the tests as well.

need_packages() {
  local sections=(build run scripts) wanted missing=() package
  if [ "$1" = test ]; then sections+=(test); fi
  if ! command -v npm >/dev/null 2>&1; then sections+=(web); fi
  wanted=$(cmake/list_packages.sh "${sections[@]}")
  for package in $wanted; do
    if [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then missing+=("$package"); fi
  done
  if [ ${#missing[@]} -eq 0 ]; then return 0; fi
  echo "Installing: ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then as_root=(sudo); fi
  "${as_root[@]}" apt-get update -qq
  DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# Compiled objects are found again from any clone.
export CCACHE_BASEDIR=$PWD
export CCACHE_NOHASHDIR=1
