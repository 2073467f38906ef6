#!/usr/bin/env bash
# Plays the game in a window of a virtual screen: breaks things, goes back, saves, loads and saves again. Nothing may fail, and the second
# file has all that the first one has. Needs xvfb, xdotool and mesa-vulkan-drivers; after `cargo game` was built.
set -euo pipefail
cd "$(dirname "$0")"
if [ -z "${INSIDE_SCREEN:-}" ]; then
  INSIDE_SCREEN=1 exec xvfb-run -a -s "-screen 0 1280x720x24" "$0"
fi
log=target/game.log
rm -f target/game.ron
target/release/examples/game > "$log" 2>&1 & game=$!
trap 'kill $game 2>/dev/null || true' EXIT

# As long as some frames take, which are slow without a graphics card.
press() { xdotool keydown "$1"; sleep 2; xdotool keyup "$1"; sleep "$2"; }
# Bodies, joints and bonds in the file. Either body may list a bond.
count() { grep -c -E '"bevy_cleave::[a-z_:]*(RigidBody|Joint)": |shear_strength: ' target/game.ron; }

sleep 20
# Without a window manager nobody gives it the keyboard.
xdotool windowfocus "$(xdotool search --pid $game | tail -1)"
xdotool mousemove 900 500 mousedown 3
sleep 2
xdotool mouseup 3
sleep 5
press e 3
press d 2
press s 2
press b 3
press F5 4
saved=$(count)
press F9 5
press F5 4
loaded=$(count)
kill -0 $game
if grep -q "Encountered an error\|panicked" "$log"; then
  grep -A2 "Encountered an error\|panicked" "$log"
  exit 1
fi
echo "$saved bodies, joints and bonds saved, $loaded when they are saved again"
[ "$saved" -gt 20 ] && [ "$saved" = "$loaded" ]
