#!/usr/bin/env bash
# What a step costs as WebAssembly: examples/steps.rs under node.
set -euo pipefail
cd "$(dirname "$0")/.."
source web/wasm.sh

build_wasm --example steps
install_bindgen
web/tools/bin/wasm-bindgen --target nodejs --no-typescript --out-dir target/steps target/web/wasm32-unknown-unknown/release/examples/steps.wasm
node -e 'console.log(require("./target/steps/steps.js").report())'
