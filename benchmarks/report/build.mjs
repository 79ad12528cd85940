// Bundles src/*.js and src/style.css into dist/*.html, one file each that needs nothing else.
//   node build.mjs [OUTPUT_FOLDER]
import { readFile, writeFile, mkdir } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const data_line = '<script type="application/json" id="plumbline-data">null</script>';

async function license(name) {
  const { version } = JSON.parse(await readFile(join(here, 'node_modules', name, 'package.json'), 'utf8'));
  return `${name} ${version}\n\n${(await readFile(join(here, 'node_modules', name, 'LICENSE'), 'utf8')).trim()}\n`;
}

async function bundle(entry) {
  const result = await build({
    entryPoints: [join(here, 'src', entry)],
    bundle: true,
    minify: true,
    write: false,
    format: 'iife',
    target: 'es2020',
    charset: 'ascii',
    legalComments: 'none',  // the page has the full licenses
  });
  return result.outputFiles[0].text.trim();
}

const output = process.argv[2] ?? join(here, 'dist');
await mkdir(output, { recursive: true });
const parts = {
  licenses: (await license('three')) + '\n' + (await license('uplot')).trim(),
  style: await bundle('style.css'),
};
for (const page of ['compare', 'debug', 'doctor', 'live']) {
  const pieces = { ...parts, title: `plumbline ${page}`, data: data_line, script: await bundle(`${page}.js`) };
  const template = await readFile(join(here, 'src', 'page.html'), 'utf8');
  const html = template.replace(/\{\{(\w+)\}\}/g, (_, name) => pieces[name]);
  if (html.split('\n').filter(line => line === data_line).length !== 1) throw new Error(`${page}: not one line of data`);
  if (/<\/?script/i.test(pieces.script)) throw new Error(`${page}: the script would end itself`);
  await writeFile(join(output, `${page}.html`), html);
  console.log(`${page}.html: ${Math.round(html.length / 1024)} KiB`);
}
