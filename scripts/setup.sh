# Set-up shared by scripts/run, scripts/test and .ci/run, which source this file: packages, configuration, build.
# Everything it does is skipped when it is done already.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '%s\n' "$*" >&2; }
die() { say "error: $*"; exit 1; }

# packages USER...: the names in packages.txt needed by these users.
packages() {
  local user
  for user in "$@"; do
    awk -v user="$user" '$1 == user { print $2 }' "$root/scripts/packages.txt"
  done
}

# missing_packages NAME...: those that are not installed.
missing_packages() {
  printf '%s\n' "$@" | grep -vxFf <(dpkg-query -W -f '${Package}\t${db:Status-Status}\n' "$@" 2>/dev/null |
    awk '$2 == "installed" { print $1 }') || true
}

# install_missing USER...: the packages of these users.
install_missing() {
  local wanted
  mapfile -t wanted < <(packages "$@")
  install_missing_names "${wanted[@]}"
}

# install_missing_names PACKAGE...: through apt, with sudo when not root. Names what it installs; does nothing when nothing is
# missing.
install_missing_names() {
  local wanted=("$@") missing as_root=() apt
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    command -v cmake >/dev/null && return  # another system, prepared by hand: CMake tells what it cannot find
    die "this system has no apt; install by hand what these Debian packages contain: ${wanted[*]}"
  fi
  mapfile -t missing < <(missing_packages "${wanted[@]}")
  [ ${#missing[@]} -gt 0 ] || return 0

  say "Installing packages that are missing: ${missing[*]}"
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null ||
      die "not root and no sudo; ask for: apt-get install --no-install-recommends ${missing[*]}"
    as_root=(sudo)
  fi
  # env: sudo drops the variable otherwise
  apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -y -q --no-install-recommends)
  # A bare machine has no lists of packages, an old one has stale ones: only then are they fetched.
  if ! apt-get -s -q install "${missing[@]}" >/dev/null 2>&1 || ! "${apt[@]}" install "${missing[@]}" >&2; then
    "${apt[@]}" update >&2 || say "warning: the lists of packages could not be updated"
    "${apt[@]}" install "${missing[@]}" >&2 ||
      die "apt could not install: ${missing[*]} (is there a network? once they are there, no network is needed)"
  fi
}

# How many compilers at once: one a core, but at least 1.5 GB for each, or the machine swaps.
parallel_jobs() {
  local cores memory limit
  cores=$(nproc 2>/dev/null || echo 1)
  memory=$(awk '/^MemAvailable:/ { print int($2 / 1024) }' /proc/meminfo 2>/dev/null)
  limit=$(cat /sys/fs/cgroup/memory.max 2>/dev/null || true)
  if [[ $limit =~ ^[0-9]+$ ]] && [ $((limit / 1048576)) -lt "${memory:-0}" ]; then memory=$((limit / 1048576)); fi
  if [ -n "$memory" ] && [ $((memory / 1500)) -lt "$cores" ]; then cores=$((memory / 1500)); fi
  echo $((cores > 0 ? cores : 1))
}

# configure PRESET [CMake options]: a preset of CMakePresets.json, in build/PRESET; only when that has not been done.
configure() {
  local preset=$1 log
  shift
  [ -f "$root/build/$preset/build.ninja" ] && [ $# -eq 0 ] && return
  mkdir -p "$root/build/$preset"
  log=$root/build/$preset/configure.log
  say "Configuring build/$preset"
  if ! (cd "$root" && cmake --preset "$preset" "$@") >"$log" 2>&1; then
    cat "$log" >&2
    die "CMake could not configure build/$preset"
  fi
}

# build PRESET [TARGET...]
build() {
  local preset=$1
  shift
  local targets=()
  [ $# -eq 0 ] || targets=(--target "$@")
  # One line that stays quiet when there is nothing to do.
  cmake --build "$root/build/$preset" --parallel "$(parallel_jobs)" "${targets[@]}" >&2
}
