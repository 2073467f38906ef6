// Drags the mouse across a body in the page at the given address, and sees two pieces; puts up each exhibit. Nothing may panic. Pictures are
// written to ../target/web.
import { chromium } from 'playwright-core';
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';

const address = process.argv[2];
const pictures = new URL('../target/web/', import.meta.url).pathname;
mkdirSync(pictures, { recursive: true });
const browser = await chromium.launch({
  executablePath: '/usr/bin/chromium',
  args: ['--headless=new', '--no-sandbox', '--no-first-run', '--disable-quic', '--disable-background-networking', '--disable-component-update',
    '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
});
try {
  const page = await browser.newPage({ viewport: { width: 960, height: 540 } });
  const failures = [];
  page.on('pageerror', error => { if (!String(error).includes('Using exceptions')) failures.push(String(error).slice(0, 300)); });
  page.on('console', message => {
    if (message.type() === 'error') console.log('console:', message.text().slice(0, 300));
    if (message.text().includes('panicked at')) failures.push(message.text().slice(0, 300));
  });
  const state = () => page.evaluate(() => window.demo?.() ?? {});
  const until = async (what, holds, seconds) => {
    const end = Date.now() + 1000 * seconds;
    for (;;) {
      const now = await state();
      if (holds(now)) return now;
      assert.ok(Date.now() < end, `${what}: ${JSON.stringify(now)}`);
      await page.waitForTimeout(100);
    }
  };
  // What was drawn when it was asked for is a frame or more behind, and a frame of Chromium's software renderer may take seconds.
  const picture = async name => {
    const now = await state();
    await until(`${name} is drawn`, s => s.frames > now.frames + 2, 60);
    await page.screenshot({ path: `${pictures}${name}.png` });
  };
  const begun = Date.now();
  await page.goto(address);
  await until('the page starts', s => s.frames > 5, 300);
  console.log(`started after ${((Date.now() - begun) / 1000).toFixed(1)} s`);

  // A pane hangs in its frame: one body, until the mouse is dragged across it.
  await page.keyboard.press('Digit2');
  const before = await until('the pane is put up', s => s.exhibit === 'Glass' && s.pieces === 1, 60);
  await picture('before');
  await page.mouse.move(340, 330);
  await page.mouse.down();
  await page.mouse.move(480, 270, { steps: 6 });
  await page.mouse.move(620, 190, { steps: 6 });
  await page.mouse.up();
  const after = await until('the swipe cuts', s => s.cuts > before.cuts, 60);
  assert.equal(after.pieces, 2, 'one swipe makes two of one');
  await picture('sliced');

  await page.keyboard.press('KeyR');
  await until('a new pane is put up', s => s.pieces === 1, 60);
  await page.mouse.click(520, 230);
  const broken = await until('a ball shatters the pane', s => s.pieces > 10, 60);
  await picture('shattered');
  await page.keyboard.press('KeyB');
  await until('the pane is whole again', s => s.pieces === 1, 60);
  await picture('rewound');

  // Every exhibit, its button's key, how many bodies it has at least.
  const exhibits = [['Wood', 4, 1], ['Brick', 3, 1], ['Stone', 5, 1], ['Concrete', 6, 0], ['Figurine', 7, 1], ['Table', 8, 2],
    ['Chain', 9, 9], ['Tower', 0, 0]];
  for (const [name, key, least] of exhibits) {
    await page.keyboard.press(`Digit${key}`);
    const shown = await until(`${name} is put up`, s => s.exhibit === name && s.pieces >= least, 60);
    const later = await until(`${name} stands`, s => s.frames > shown.frames + 5, 60);
    await picture(name.toLowerCase());
    console.log(`${name}: ${later.pieces} bodies, ${later.step_ms} ms a step`);
  }

  // The tower is static, none of the bodies that move, until stones come off.
  await page.mouse.click(480, 250);
  const tower = await until('a ball takes stones off the tower', s => s.pieces > 10, 60);
  await picture('tower_hit');

  await page.keyboard.press('Digit1');
  await until('all is put up', s => s.exhibit === 'All', 60);
  await page.waitForTimeout(5000);
  const rest = await state();
  await picture('all');
  console.log(`two pieces of a swipe, ${broken.pieces} bodies of a pane, ${tower.pieces} of a tower; ${rest.pieces} bodies: ${rest.step_ms} ms a step, ${rest.frame_ms} ms a frame`);
  assert.deepEqual(failures, [], 'nothing fails in the page');
} finally {
  await browser.close();
}
