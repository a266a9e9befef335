// SPDX-License-Identifier: Apache-2.0
// The report's pixel section in a Chromium that Playwright steers: clicks and arrow keys choose a pixel, of which its
// spectrum, its maps and its flags are told.
// Usage: node report_pixel.mjs REPORT_URL CHROMIUM BAND_COUNT [PICTURE.png]; a report of 80 x 80 pixels.
import assert from 'node:assert/strict';
import { chromium } from 'playwright-core';

const [url, program, bandCount, picture] = process.argv.slice(2);

async function look(page) {
  const chart = page.locator('#pixel-chart');
  const saidOf = () => page.locator('#pixel-said').textContent();
  const pixel = async () => (await saidOf()).match(/Pixel (\d+), (\d+)/).slice(1).map(Number);
  await page.locator('#pixel-rows tr').nth(4).waitFor({ state: 'attached' });
  assert.equal(await chart.locator('circle').count(), Number(bandCount), 'a dot a band');
  assert.deepEqual(await pixel(), [40, 40], 'starts in the middle: 80 pixels in steps of 2');
  await page.locator('#pixel-stage').press('ArrowRight');
  await page.locator('#pixel-stage').press('Shift+ArrowUp');
  assert.deepEqual(await pixel(), [42, 20], 'the arrow keys move');
  const before = await chart.innerHTML();
  const map = page.locator('#maps img.pixels').first();
  const box = await map.boundingBox();
  await map.click({ position: { x: 0.26 * box.width, y: 0.76 * box.height } });
  assert.deepEqual(await pixel(), [20, 60], 'a click on a map chooses its pixel');
  assert.notEqual(await chart.innerHTML(), before, 'the spectrum is another');
  // Without noise beyond the default's 1 %: what the fit predicts is near what was measured.
  assert.match(await saidOf(), /as good as the measurement allows/);
  const row = await page.locator('#pixel-rows tr').first().locator('> *').allTextContents();
  assert.equal(row[0], 'C_m');
  assert.ok(Number(row[2]) > 0.03 && Number(row[2]) < 0.13, `melanin: ${row}`);
  assert.match(row[3], /^\u00b1/);
  // docs/formats.md, flags.exr: six bits, each with a name for whoever looks at a pixel.
  const names = JSON.parse(await page.locator('#pixel-info').textContent()).flags;
  assert.deepEqual(names, ['at a bound', 'masked', 'not converged', 'not identifiable', 'outside the model', 'unexplained']);
  if (picture) await page.locator('#pixel').screenshot({ path: picture });
}

const browser = await chromium.launch({ executablePath: program });
const said = []; // errors that the page reported
try {
  const page = await browser.newPage({ viewport: { width: 1280, height: 1000 } });
  page.on('pageerror', (error) => said.push(String(error)));
  await page.goto(url);
  await look(page);
  assert.deepEqual(said, [], 'errors on the page');
} finally {
  await browser.close();
}
