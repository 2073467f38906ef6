#!/usr/bin/env bash
# Loads the playground in headless Chromium, drags the mouse across a body and sees two pieces. After web/build.sh.
set -euo pipefail
cd "$(dirname "$0")"
[ -d node_modules/playwright-core ] || npm install --no-save --no-audit --no-fund playwright-core@1.64.1
python3 -m http.server "${PORT:-8123}" --bind 127.0.0.1 --directory site > /dev/null 2>&1 & server=$!
trap 'kill $server' EXIT
sleep 1
node test.mjs "http://127.0.0.1:${PORT:-8123}/index.html"
