#!/usr/bin/env bash
# Builds the playground for the web into web/site: WebAssembly with WebGL2, from Debian's compiler (web/setup.sh).
set -euo pipefail
cd "$(dirname "$0")/.."
source web/wasm.sh

build_wasm --bin cleave_demo
install_bindgen
mkdir -p web/site
web/tools/bin/wasm-bindgen --target web --no-typescript --remove-name-section --remove-producers-section \
  --out-dir web/site target/web/wasm32-unknown-unknown/release/cleave_demo.wasm
cp web/index.html web/site/
gzip -9 -k -f web/site/cleave_demo_bg.wasm
ls -l web/site
