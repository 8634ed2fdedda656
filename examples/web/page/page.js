// The page around the app: switches, frame time, and what is missing.
import init, * as app from './app.js';

const message = document.getElementById('message');
const frame = document.getElementById('frame');

/** What the app calls each switch, and whether it is on. */
function switches() {
  const inputs = document.querySelectorAll('#switches input:not(#forward)');
  return [...inputs].map((input) => [input.id, input.checked]);
}

function apply() {
  for (const [name, on] of switches()) app.set_switch(name, on);
  app.set_place(document.getElementById('place').value);
}

/** So long without a frame, in milliseconds, and something is wrong. */
const PATIENCE = 60000;
let last = { frames: 0, time: performance.now() };

function show() {
  const frames = app.frames();
  const now = performance.now();
  if (frames !== last.frames || document.hidden) last = { frames, time: now };
  const state = app.compiling() > 0 ? `${app.renderer()}, ${app.compiling()} pipelines compiling` : app.renderer();
  frame.textContent = frames > 0 ? `${app.frame_milliseconds().toFixed(1)} ms a frame, ${state}` : '';
  if (now - last.time > PATIENCE) message.textContent = 'No frame for a minute: the console may say why.';
  else if (frames > 0) message.textContent = '';
}

/** What stands in the way, or nothing. */
async function missing() {
  if (!navigator.gpu) {
    const why = isSecureContext ? '' : '\nIt is there only on https:// and on localhost.';
    return `This browser has no WebGPU.${why}`;
  }
  if (!(await navigator.gpu.requestAdapter())) return 'WebGPU is there, but no adapter for it: no GPU that this browser trusts.';
  return '';
}

async function main() {
  const obstacle = await missing();
  if (obstacle) {
    message.textContent = obstacle;
    return;
  }
  await init();
  // For those who look into the page.
  window.app = app;
  apply();
  document.getElementById('switches').addEventListener('change', apply);
  app.start('#view', Math.min(Number(new URLSearchParams(location.search).get('amount') ?? 1), 1));
  setInterval(show, 250);
}

addEventListener('error', (event) => { message.textContent = `It has stopped: ${event.message}`; });
main().catch((error) => { message.textContent = `It has stopped: ${error}`; });
