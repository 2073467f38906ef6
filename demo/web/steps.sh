#!/usr/bin/env bash
# What a step costs natively and as WebAssembly under node, there with and without `simd128`.
set -euo pipefail
cd "$(dirname "$0")/.."
source web/wasm.sh

echo native
cargo run --release -p cleave_steps
install_bindgen
for features in +simd128 -simd128; do
  TARGET="target/web$features" FEATURES=$features build_wasm -p cleave_steps
  web/tools/bin/wasm-bindgen --target nodejs --no-typescript --out-dir "target/steps$features" "target/web$features/wasm32-unknown-unknown/release/cleave_steps.wasm"
  echo "WebAssembly, $features"
  node -e "console.log(require('./target/steps$features/cleave_steps.js').report())"
done
