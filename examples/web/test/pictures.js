// In the page: copies the canvas, and compares copies. `window.pictures` has them by name.
window.pictures = {};
window.deviceErrors = [];

// The test begins without what the page begins with.
addEventListener('DOMContentLoaded', () => {
  for (const input of document.querySelectorAll('[type=checkbox]:not(#motion)')) input.checked = false;
  document.getElementById('forward').checked = true;
});

// What goes wrong on the GPU: the app sees it too, but tells of it in its own way, or not at all.
if (window.GPUAdapter) {
  const requestDevice = GPUAdapter.prototype.requestDevice;
  GPUAdapter.prototype.requestDevice = async function (descriptor) {
    const device = await requestDevice.call(this, descriptor);
    device.lost.then(({ message }) => window.deviceErrors.push(`device lost: ${message}`));
    device.addEventListener('uncapturederror', ({ error }) => window.deviceErrors.push(error.message));
    return device;
  };
}

/** What has ended the app, or nothing. */
window.ended = () => {
  const message = document.getElementById('message')?.textContent ?? '';
  return window.deviceErrors.join('\n') || (message.startsWith('It has stopped') ? message : '');
};

/** Copies the canvas. To be called while what the app has drawn is still there. */
function copy(name) {
  const view = document.getElementById('view');
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [view.width, view.height];
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.drawImage(view, 0, 0);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  window.pictures[name] = data;
  let sum = 0;
  for (let i = 0; i < data.length; i++) sum += i % 4 < 3 ? data[i] : 0;
  const mean = sum / (data.length * 0.75);
  return { width: canvas.width, height: canvas.height, mean, png: canvas.toDataURL('image/png') };
}

// The canvas has its picture from when the app takes the texture until the browser shows it: between them come microtasks.
let wanted = null;
const getCurrentTexture = window.GPUCanvasContext?.prototype.getCurrentTexture;
if (getCurrentTexture) {
  GPUCanvasContext.prototype.getCurrentTexture = function () {
    if (wanted) {
      const { name, resolve } = wanted;
      wanted = null;
      queueMicrotask(() => resolve(copy(name)));
    }
    return getCurrentTexture.call(this);
  };
}

/** A copy of the next frame. */
window.capture = (name) =>
  new Promise((resolve) => {
    wanted = { name, resolve };
  });

/** Peak signal to noise in dB, over colours; without end where pictures are equal. */
window.psnr = (a, b) => {
  const [x, y] = [window.pictures[a], window.pictures[b]];
  let sum = 0;
  for (let i = 0; i < x.length; i++) sum += i % 4 < 3 ? (x[i] - y[i]) ** 2 : 0;
  return 10 * Math.log10(255 ** 2 / (sum / (x.length * 0.75)));
};
