// Opens the page in a headless Chromium, toggles every switch, reads pixels back and compares them: lean with forward, and each effect
// with none. Fails on what the console or the device complains of. `node test.mjs FOLDER`; ../test.sh has the environment.
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { serve } from './serve.mjs';

const { chromium } = createRequire(import.meta.url)('playwright-core');

/** Lean pictures are at least so near to forward's, in dB. */
const NEAR = 45;
/** Pictures nearer than this are the same but for rounding. */
const SAME = 60;
/** What an effect changes is further away than this. */
const CHANGED = 65;
/** Places of the street, and the effects that show best at each. */
const PLACES = {
  street: ['auto-exposure'],
  stall: ['ambient-occlusion', 'diffuse-gi'],
  puddle: ['reflections'],
  cats: ['subsurface-scattering'],
};
const EFFECTS = Object.values(PLACES).flat();
/** Frames after which nothing changes any more: lights are found, history is filled. */
const SETTLED = Number(process.env.SETTLED ?? 8);
/** The share of the scene that there is. */
const AMOUNT = process.env.AMOUNT ?? 0.1;
/** Width of the canvas, of 16 to 9. */
const WIDTH = Number(process.env.WIDTH ?? 320);
const LIMIT = 1000 * Number(process.env.LIMIT ?? 600);

/** A canvas is shown through what shares textures with WebGPU: without ANGLE on Vulkan its first picture ends the device. */
const SOFTWARE = [
  '--use-webgpu-adapter=swiftshader',
  '--enable-features=Vulkan',
  '--use-vulkan=swiftshader',
  '--use-angle=swiftshader',
];
const FLAGS = (process.env.CHROMIUM_FLAGS ?? SOFTWARE.join(' ')).split(' ').filter((flag) => flag);

const failures = [];
function check(holds, text) {
  console.log(`${holds ? 'ok' : 'FAILED'}: ${text}`);
  if (!holds) failures.push(text);
}

const began = Date.now();
const server = await serve(process.argv[2]);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM,
  args: ['--no-sandbox', '--enable-unsafe-webgpu', '--ignore-gpu-blocklist', ...FLAGS],
});
const page = await browser.newPage({ viewport: { width: WIDTH + 16, height: (WIDTH * 9) / 16 + 240 } });
page.setDefaultTimeout(LIMIT);
const complaints = [];
page.on('console', (message) => {
  // Colours of Bevy's log come as further arguments.
  const text = message.text().replaceAll('%c', '').split(' color: ')[0];
  if (process.env.VERBOSE) console.log(`    ${message.type()}: ${text}`);
  if (message.type() === 'error' || text.startsWith('ERROR')) complaints.push(text);
});
page.on('pageerror', (error) => complaints.push(String(error)));
await page.addInitScript({ path: path.join(path.dirname(fileURLToPath(import.meta.url)), 'pictures.js') });

/** Whatever ends the app ends the test. */
async function until(condition, argument) {
  await page.waitForFunction(
    ([source, value]) => window.ended() || new Function('app', 'value', `return ${source}`)(window.app, value),
    [condition, argument],
    { polling: 100 },
  );
  const why = await page.evaluate(() => window.ended());
  if (why) throw new Error(why);
}

/** Until everything is compiled and has been seen for some frames. */
async function settle() {
  await until('app.compiling() === 0');
  const frames = await page.evaluate(() => window.app.frames());
  await until('app.frames() >= value', frames + SETTLED);
  await until('app.compiling() === 0');
}

async function toggle(on, ...ids) {
  for (const id of ids) await page.locator(`#${id}`).setChecked(on, { force: true });
  await settle();
}

async function toggleLean() {
  await toggle(true, 'lean');
  await until('/^(lean|off)/.test(app.renderer())');
  const renderer = await page.evaluate(() => window.app.renderer());
  check(renderer === 'lean', `the camera is ${renderer}`);
  await settle();
}

async function capture(name) {
  const picture = await page.evaluate((picture) => window.capture(picture), name);
  const [milliseconds, renderer] = await page.evaluate(() => [window.app.frame_milliseconds(), window.app.renderer()]);
  console.log(`${name}: ${picture.width}×${picture.height}, ${milliseconds.toFixed(0)} ms a frame, ${renderer}`);
  check(picture.mean > 2, `${name} is not black (mean ${picture.mean.toFixed(1)} of 255)`);
  if (process.env.WEB_PICTURES) {
    fs.mkdirSync(process.env.WEB_PICTURES, { recursive: true });
    fs.writeFileSync(path.join(process.env.WEB_PICTURES, `${name}.png`), Buffer.from(picture.png.split(',')[1], 'base64'));
  }
}

const psnr = (a, b) => page.evaluate(([first, second]) => window.psnr(first, second), [a, b]);

/** The picture of a place by forward, by lean, and with each of its effects. */
async function testPlace(place, effects) {
  await page.locator('#place').selectOption(place);
  await toggle(true, 'forward');
  await capture(`${place}, forward`);
  await toggleLean();
  await capture(`${place}, lean`);
  const near = await psnr(`${place}, forward`, `${place}, lean`);
  check(near >= NEAR, `${place}: lean is at ${near.toFixed(1)} dB from forward, ${NEAR} are asked for`);

  for (const effect of effects) {
    await toggle(true, effect);
    await capture(`${place}, ${effect}`);
    const changed = await psnr(`${place}, lean`, `${place}, ${effect}`);
    check(changed < CHANGED, `${effect} changes the picture: ${changed.toFixed(1)} dB from lean`);
    await toggle(false, effect);
    await capture(`${place}, after ${effect}`);
    const left = await psnr(`${place}, lean`, `${place}, after ${effect}`);
    check(left > SAME, `${effect} leaves nothing behind: ${left.toFixed(1)} dB from lean before`);
  }
}

/** Two pictures in which nothing has changed. */
async function testStill(name) {
  await capture(name);
  await capture(`${name} again`);
  const noise = await psnr(name, `${name} again`);
  check(noise > SAME, `nothing moves in ${name}: ${noise.toFixed(1)} dB from one picture to the next`);
}

async function test() {
  await page.goto(`${server.url}?amount=${AMOUNT}`);
  await until('app?.frames() > 2');
  await toggle(false, 'motion');
  await testStill('forward');
  await toggleLean();
  await testStill('lean');
  for (const [place, effects] of Object.entries(PLACES)) await testPlace(place, effects);

  await page.locator('#place').selectOption('street');
  await toggle(true, ...EFFECTS);
  await capture('all');
  await toggle(false, ...EFFECTS);
  await capture('lean at last');
  const same = await psnr('lean', 'lean at last');
  check(same > SAME, `without effects it is as before: ${same.toFixed(1)} dB`);

  await toggle(true, 'forward');
  await capture('forward at last');
  const back = await psnr('forward', 'forward at last');
  check(back > SAME, `forward is as before: ${back.toFixed(1)} dB`);

  await toggle(true, 'ambient-occlusion');
  await capture('forward with ambient-occlusion');
  await toggle(true, 'motion');
}

/** A browser that lacks it is told so. */
async function withoutWebGpu() {
  const bare = await browser.newPage();
  await bare.addInitScript(() => Object.defineProperty(Navigator.prototype, 'gpu', { get: () => undefined }));
  await bare.goto(server.url);
  await bare.waitForFunction(() => !document.getElementById('message').textContent.startsWith('Loading'));
  const text = await bare.locator('#message').textContent();
  check(text.includes('no WebGPU'), `without WebGPU the page says: ${text}`);
  await bare.close();
}

try {
  await withoutWebGpu();
  await test();
} catch (error) {
  check(false, String(error));
}
const errors = await page.evaluate(() => window.deviceErrors).catch(() => []);
for (const complaint of [...complaints, ...errors]) check(false, complaint.slice(0, 2000));
if (complaints.length + errors.length === 0) console.log('ok: no error on the console, none of the device');
await browser.close();
server.close();
const seconds = ((Date.now() - began) / 1000).toFixed(0);
console.log(`${failures.length > 0 ? `${failures.length} failed` : 'all passed'} (${seconds} s)`);
process.exit(failures.length > 0 ? 1 : 0);
