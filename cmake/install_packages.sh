# Sourced by run.sh and test.sh: installs with apt what is missing, on Debian 12 or a kindred system.
# `need_packages build` for building and running, `need_packages test` for the tests as well.

build_packages=(
  build-essential ca-certificates ccache cmake curl ninja-build pkg-config python3
  libarchive-dev libboost-dev libceres-dev libcli11-dev libdeflate-dev libeigen3-dev libfmt-dev libgdal-dev libjpeg62-turbo-dev libopencv-dev
  libpng-dev libproj-dev libseccomp-dev libsqlite3-dev libssl-dev libtiff-dev libtinyxml2-dev libturbojpeg0-dev
  libwebp-dev libxxhash-dev nlohmann-json3-dev proj-data
  zlib1g-dev
)
test_packages=(
  libbenchmark-dev libgmock-dev libgtest-dev librapidcheck-dev gdal-bin python3-gdal python3-jsonschema python3-jsonschema libimage-exiftool-perl sqlite3
  chromium
)

need_packages() {
  local wanted=("${build_packages[@]}") missing=()
  if [ "$1" = test ]; then wanted+=("${test_packages[@]}"); fi
  # A newer node than Debian's is as good.
  if ! command -v npm >/dev/null 2>&1; then wanted+=(nodejs npm); fi
  local package
  for package in "${wanted[@]}"; do
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
