# Debian packages, sourced by the other scripts from the top of the house.

# What every build needs.
base_packages=(
  build-essential cmake ninja-build ccache pkg-config git ca-certificates
  libeigen3-dev libboost-dev libceres-dev libcli11-dev libfmt-dev libgmock-dev libgtest-dev liblz4-dev libmatio-dev
  libpagmo-dev libpng-dev librandom123-dev libspdlog-dev libsqlite3-dev libssl-dev libtbb-dev libtinyxml2-dev
  liburdfdom-dev libxsimd-dev libyaml-cpp-dev libzstd-dev nlohmann-json3-dev
  libjs-dygraphs
)
# The other engines, pictures, meshes, benchmarks, runs over several machines and the Python module: what `minimal` does without.
engine_packages=(
  $(sed -n 's/^set(engine_packages \(.*\))$/\1/p' backends/*/engine.cmake)
  libosmesa6-dev libassimp-dev libbenchmark-dev python3
  libopenmpi-dev openmpi-bin
  pybind11-dev python3-dev python3-numpy
)
# What the tests of pages in a real browser need.
browser_packages=(chromium chromium-driver python3)
# What `scripts/lint` needs.
lint_packages=(clang-format clang-tidy)

# Installs those of the named packages that are missing; without any it makes no call to apt, so it works offline.
install_missing() {
  local package missing=()
  for package in "$@"; do
    [[ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" == installed ]] || missing+=("$package")
  done
  ((${#missing[@]})) || return 0
  echo "Installing ${#missing[@]} packages: ${missing[*]}"

  local root=()
  if [[ "$(id -u)" != 0 ]]; then
    if ! command -v sudo >/dev/null; then
      echo "These packages are missing and neither root nor sudo is at hand: ${missing[*]}" >&2
      return 1
    fi
    root=(sudo)
  fi
  local apt=("${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300)
  # A fresh image has no package lists, an old one has lists of versions that are gone: then fetch them (again).
  local known=1
  for package in "${missing[@]}"; do
    apt-cache show "$package" >/dev/null 2>&1 || known=0
  done
  if ((known)) && "${apt[@]}" install --no-install-recommends "${missing[@]}"; then
    return 0
  fi
  "${apt[@]}" update
  "${apt[@]}" install --no-install-recommends "${missing[@]}"
}
