# SPDX-License-Identifier: Apache-2.0
# Set-up shared by ./render, ./check and .ci/run: packages and the build. Sourced, not run; expects
# $root (this checkout) and `set -euo pipefail`.

# What a build of brume needs beside a bare Debian 12. Fuzzing and the format check add clang.
brume_packages=(
  build-essential cmake ninja-build ca-certificates
  libembree-dev libtbb-dev libopenexr-dev libglm-dev libfmt-dev libcli11-dev nlohmann-json3-dev
  libstb-dev libgtest-dev libgmock-dev libbenchmark-dev
)
brume_ci_packages=(clang clang-format libclang-rt-14-dev)

# Installs those of the given packages that are missing; asks dpkg only, when none is.
install_packages() {
  local missing=() package
  for package in "$@"; do
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true) == installed ]] ||
      missing+=("$package")
  done
  ((${#missing[@]} == 0)) && return
  local as_root=()
  if ((EUID != 0)); then
    command -v sudo >/dev/null ||
      { echo "these packages are missing, and neither root nor sudo is at hand: ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
  fi
  echo "Installing ${missing[*]}" >&2
  # Only what goes wrong is worth reading.
  "${as_root[@]}" apt-get -qq update </dev/null >/dev/null
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 \
    install -y --no-install-recommends "${missing[@]}" </dev/null >/dev/null
}

# Compilers that run at once: one per processor, but each may take 1 GiB (2 GiB with sanitizers).
build_jobs() {
  local gib_each=${1:-1} processors memory_kib
  processors=$(nproc)
  memory_kib=$(awk '/^MemAvailable:/ {print $2}' /proc/meminfo)
  local by_memory=$((memory_kib / (gib_each * 1024 * 1024)))
  ((by_memory < 1)) && by_memory=1
  echo $((processors < by_memory ? processors : by_memory))
}

# Whether the folder is configured, and with each of $cmake_options (a compiler may be stored with its path).
is_configured() {
  local folder=$1 option
  [[ -f $folder/build.ninja ]] || return 1
  for option in "${cmake_options[@]}"; do
    [[ $option =~ ^-D([^=]+)=(.*)$ ]] || return 1
    grep -q "^${BASH_REMATCH[1]}:[A-Z]*=${BASH_REMATCH[2]}\$" "$folder/CMakeCache.txt" ||
      [[ ${BASH_REMATCH[1]} == CMAKE_CXX_COMPILER ]] || return 1
  done
}

# build PRESET FOLDER [TARGET...]: configures once, with $cmake_options, then lets ninja decide; silent
# when nothing is to do.
cmake_options=()
build() {
  local preset=$1 folder=$2 gib=1 launcher=() log
  shift 2
  if [[ $preset != release ]]; then gib=2; fi
  if ! is_configured "$root/$folder"; then
    if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
    log=$(cd "$root" &&
      cmake --preset "$preset" -B "$folder" "${launcher[@]}" "${cmake_options[@]}" 2>&1) ||
      { printf '%s\n' "$log" >&2; exit 2; }
  fi
  ninja -C "$root/$folder" -j "$(build_jobs "$gib")" "$@" |
    sed -u '/^ninja: \(Entering\|no work\)/d; /Re-checking globbed/d' >&2 || exit 2
}
