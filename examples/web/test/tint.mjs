// Has Tint read every .wgsl of a folder, and fails on what it does not take. `node tint.mjs FOLDER`
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

// From where NODE_PATH says: `import` does not look there.
const found = createRequire(import.meta.url).resolve('webgpu');
const { create, globals } = await import(pathToFileURL(found));
Object.assign(globalThis, globals);

const folder = process.argv[2];
// Held: when it is collected, its adapters go.
const gpu = create([]);
const adapter = await gpu.requestAdapter();
if (!adapter) {
  console.log('Dawn finds no adapter: Tint has not read them. VK_DRIVER_FILES may name a Vulkan driver.');
  process.exit(2);
}
const subgroups = adapter.features.has('subgroups');
const device = await adapter.requestDevice({ requiredFeatures: subgroups ? ['subgroups'] : [] });
// Messages are asked for; what Dawn prints beside is the same once more.
device.addEventListener('uncapturederror', (event) => event.preventDefault());

let wrong = 0;
let warnings = 0;
const files = fs.readdirSync(folder).filter((name) => name.endsWith('.wgsl'));
for (const name of files) {
  const code = fs.readFileSync(path.join(folder, name), 'utf8');
  const { messages } = await device.createShaderModule({ code, label: name }).getCompilationInfo();
  const errors = messages.filter((message) => message.type === 'error');
  warnings += messages.length - errors.length;
  wrong += errors.length > 0;
  for (const { lineNum, linePos, message } of errors) console.log(`${name}:${lineNum}:${linePos}: ${message}`);
}
console.log(`Tint (${adapter.info.description || adapter.info.vendor}): ${files.length} shaders, ${wrong} wrong, ${warnings} warnings`);
process.exit(wrong > 0 ? 1 : 0);
