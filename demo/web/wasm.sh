# To be sourced: how to build for WebAssembly with Debian's compiler.

# A cargo build of the arguments, optimized for size but for what moves bodies, with vectors of four lanes unless FEATURES says otherwise.
build_wasm() {
  CARGO_TARGET_DIR="${TARGET:-target/web}" \
  RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=wasm-ld-22 CARGO_PROFILE_RELEASE_OPT_LEVEL=s \
    RUSTFLAGS='--cfg getrandom_backend="wasm_js" -C target-feature='"${FEATURES:-+simd128}" \
    cargo build --ignore-rust-version -Zbuild-std=std,panic_abort --target wasm32-unknown-unknown --release "$@"
}

# wasm-bindgen in the version that Cargo.lock has.
install_bindgen() {
  local version
  version=$(grep -A1 '^name = "wasm-bindgen"$' Cargo.lock | sed -n 's/^version = "\(.*\)"/\1/p')
  web/tools/bin/wasm-bindgen --version 2>/dev/null | grep -q " $version$" ||
    cargo install "wasm-bindgen-cli@$version" --debug --root web/tools
}
