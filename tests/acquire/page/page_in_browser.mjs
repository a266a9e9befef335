// SPDX-License-Identifier: Apache-2.0
// What an operator does on the page, step by step, in a Chromium that Playwright steers, by what can be seen there.
// Usage: node page_in_browser.mjs URL CHROMIUM [PICTURES_FOLDER]; the daemon at URL has a small station whose card is full
// at the third press.
import assert from 'node:assert/strict';
import path from 'node:path';
import { chromium } from 'playwright-core';

const [url, program, pictures] = process.argv.slice(2);
const MOST_QUESTIONS = 20; // a session that asks more does not come to an end

const asked = (page) => page.locator('#ask:not(.hide)');
const inState = (page, name) => page.locator('#state', { hasText: name });

async function picture(page, name) {
  if (pictures) await page.screenshot({ path: path.join(pictures, `${name}.png`), fullPage: true });
}

/** Presses Enter for whatever is asked, until `there` is to be seen. */
async function answerUntil(page, there) {
  for (let n = 0; n < MOST_QUESTIONS; ++n) {
    await there.or(asked(page)).first().waitFor();
    if (await there.isVisible()) return;
    const sentence = await page.locator('#sentence').innerText();
    await page.keyboard.press('Enter');
    await page.locator('#ask:not(.hide) #sentence', { hasText: sentence }).waitFor({ state: 'detached' });
  }
  assert.fail('asked too often');
}

async function fillIn(page, form) {
  for (const [id, value] of Object.entries(form)) await page.locator(`#${id}`).fill(value);
}

async function wholeSession(page) {
  await page.locator('#formbox').waitFor(); // it has the helm
  assert.equal(await page.title(), 'dermap station');
  await inState(page, 'Ready').waitFor();
  await picture(page, 'ready');
  await fillIn(page, { session: 'one', subject: 'S7', site: 'forearm' });
  await page.locator('#session').press('Enter'); // sends the form
  await inState(page, 'Waiting for you').waitFor();
  assert.match(await page.locator('#sentence').innerText(), /black/);
  await picture(page, 'asked');
  // A full card at the third press: the page says what to do, and goes on.
  await answerUntil(page, page.locator('#ask.fault:not(.hide)'));
  assert.match(await page.locator('#sentence').innerText(), /card/);
  assert.match(await page.locator('#remedy').innerText(), /^Put an empty card into it/);
  const border = await page.locator('#ask').evaluate((e) => getComputedStyle(e).borderColor);
  assert.equal(border, 'rgb(255, 92, 87)', 'a fault is red');
  await picture(page, 'fault');
  await answerUntil(page, inState(page, 'Complete'));
  assert.equal(await page.locator('#now').innerText(), 'Session complete');
  assert.match(await page.locator('#count').innerText(), /^6 of 6/);
  await page.waitForFunction(() => document.images.length === 6 && [...document.images].every((i) => i.naturalWidth > 0));
  assert.equal(await page.locator('.card svg rect').count(), 6 * 64, 'a histogram for each frame');
  assert.equal(await page.locator('#window').innerText(), 'found', 'the window was found');
  await picture(page, 'complete');
}

async function twoWindows(page) {
  const watcher = await page.context().newPage();
  await watcher.goto(url);
  await watcher.locator('#helm').waitFor();
  assert.ok(await watcher.locator('#formbox').isHidden(), 'who watches cannot start');
  assert.equal(await watcher.locator('[data-retake]').count(), 0, 'who watches cannot retake');
  const before = await page.getByAltText('frame 6', { exact: true }).getAttribute('src');
  await page.locator('[data-retake="6"]').click();
  // The old session is complete too: another picture of the frame tells that this one is.
  const again = (of) => of.locator(`main:has(#state:has-text("Complete")) img[alt="frame 6"]:not([src="${before}"])`);
  await answerUntil(page, again(page));
  await again(watcher).waitFor();
  await picture(watcher, 'watching');
  await watcher.close();
}

/** Every control can be reached by Tab and shows that it has been. */
async function keyboard(page) {
  const reached = new Set();
  await page.evaluate(() => { document.activeElement.blur(); scrollTo(0, 0); });
  for (let n = 0; n < 40; ++n) {
    await page.keyboard.press('Tab');
    const at = await page.evaluate(() => {
      const e = document.activeElement;
      return { name: e.id || e.dataset.retake || e.className,
               outline: e === document.body ? '3px' : getComputedStyle(e).outlineWidth };
    });
    assert.equal(at.outline, '3px', `no visible focus on ${at.name}`);
    reached.add(at.name);
  }
  for (const control of ['session', 'subject', 'site', 'notes', 'reference', 'resume', 'go', '1', '6'])
    assert.ok(reached.has(control), `Tab never reaches ${control}: ${[...reached]}`);
}

async function endAndResume(page) {
  page.on('dialog', (dialog) => dialog.accept());
  await fillIn(page, { session: 'two' });
  await page.locator('#resume').uncheck();
  await page.getByRole('button', { name: 'Start' }).click();
  await inState(page, 'Waiting for you').waitFor();
  await page.keyboard.press('e');
  await inState(page, 'Ended early').waitFor();
  assert.match(await page.locator('#now').innerText(), /can be resumed/);
  await picture(page, 'ended');
  await page.locator('#goon:focus').waitFor();
  await page.keyboard.press('Enter'); // goes on without the form
  await inState(page, 'Waiting for you').waitFor();
  await page.keyboard.press('e');
  await inState(page, 'Ended early').waitFor();
  await fillIn(page, { session: 'two' });
  await page.locator('#resume').check();
  await page.getByRole('button', { name: 'Start' }).click();
  await inState(page, 'Waiting for you').waitFor();
  await answerUntil(page, inState(page, 'Complete'));
}

/** A page that hears nothing any more says so in large letters, and no longer once it does. */
async function lostConnection(page) {
  const alarm = page.locator('#alarm:not(.hide)');
  await page.route('**/api/events', (route) => route.abort());
  await page.reload();
  await alarm.waitFor();
  assert.match(await alarm.innerText(), /No connection to the daemon/);
  await picture(page, 'lost');
  await page.unroute('**/api/events');
  await alarm.waitFor({ state: 'detached' }); // it tries again by itself
  await inState(page, 'Complete').waitFor();
}

async function narrow(page) {
  for (const width of [360, 800]) {
    await page.setViewportSize({ width, height: 800 });
    const needed = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(needed <= width, `at ${width} px it scrolls sideways: ${needed}`);
    await picture(page, `narrow_${width}`);
  }
}

const browser = await chromium.launch({ executablePath: program });
const said = []; // errors that the page reported
try {
  const context = await browser.newContext({ viewport: { width: 1300, height: 1000 } });
  context.setDefaultTimeout(60000); // only so that a failure ends
  context.on('page', (opened) => opened.on('pageerror', (error) => said.push(String(error))));
  const page = await context.newPage();
  await page.goto(url);
  for (const step of [wholeSession, twoWindows, keyboard, endAndResume, lostConnection, narrow]) {
    await step(page);
    console.log(`done: ${step.name}`);
  }
  assert.deepEqual(said, [], 'errors on the page');
} finally {
  await browser.close();
}
