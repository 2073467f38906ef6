#!/usr/bin/env bash
# What Debian has to bring: the compiler with the sources of its library, for a target that rustup's has not; and, for the test, a browser.
set -euo pipefail
apt-get update -q
apt-get install -y -q --no-install-recommends rustc-web rust-web-src lld-22 chromium nodejs
