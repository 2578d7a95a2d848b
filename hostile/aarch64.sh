#!/usr/bin/env bash
# The aarch64 wheel in Debian's Python for that processor, under qemu-user: an example touched, and tests of the kernel.
#     bash hostile/aarch64.sh out/wheels/*manylinux*aarch64.whl
# Needs qemu-user-static and apt; nothing is installed on this machine.
set -euo pipefail
wheel="$(realpath "$1")"
cd "$(dirname "$0")/.."
there="$(mktemp -d)"
trap 'rm -rf "$there"' EXIT

mkdir -p "$there"/{lists,cache/archives,root,project}/partial
touch "$there/status"
apt="apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User=root
    -o Dir::State::lists=$there/lists -o Dir::State::status=$there/status -o Dir::Cache=$there/cache"
$apt update
$apt install -y --download-only --no-install-recommends python3.11 libstdc++6 >/dev/null
for package in "$there"/cache/archives/*.deb; do dpkg-deb -x "$package" "$there/root"; done
python3 -m pip install --quiet --target "$there/site" --only-binary=:all: --python-version 3.11 \
    --platform manylinux_2_17_aarch64 --platform manylinux_2_27_aarch64 --platform manylinux_2_28_aarch64 \
    "$wheel" 'scipy>=1.14.1' pytest hypothesis

# The tests of a checkout without its sources: what is imported is what the wheel brought.
cp -r tests native hostile benchmarks examples pyproject.toml "$there/project"
cd "$there/project"
export PYTHONPATH="$there/site" OPENBLAS_NUM_THREADS=1
python="qemu-aarch64-static -L $there/root $there/root/usr/bin/python3.11"
$python -m varishold touch examples/surfaces.npz --frames press
$python -m pytest -q -p no:cacheprovider tests/test_levelset_{contacts,laws,reference,ties,turns}.py \
    tests/test_frame_{fill,noise,repair_level}.py tests/test_touch_{kernel,recognize,state}.py
