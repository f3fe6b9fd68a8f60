// node bundle.mjs MODULES SOURCE OUT: bundles the page. MODULES: the folder node_modules; SOURCE: this one; OUT: of
// index.html, page.js, page.css and licenses.txt.
import { createRequire } from 'node:module';
import { copyFileSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';

const [modules, source, out] = process.argv.slice(2);
const { build } = createRequire(join(modules, 'x'))('esbuild');

mkdirSync(out, { recursive: true });
const { metafile } = await build({
  entryPoints: [join(source, 'src/main.ts')],
  outfile: join(out, 'page.js'),
  bundle: true,
  format: 'esm',
  target: 'es2022',
  minify: true,
  legalComments: 'none', // licenses.txt has them
  nodePaths: [modules],
  metafile: true,
  logLevel: 'warning',
});
const bundled = new Set(Object.keys(metafile.inputs).map((path) => resolve(path)));
for (const name of readdirSync(join(source, 'src'), { recursive: true })) {
  const path = resolve(join(source, 'src', name));
  if (/(?<!\.d)\.ts$/.test(name) && !bundled.has(path)) throw new Error(`${path} is imported by nothing`);
}
copyFileSync(join(source, 'index.html'), join(out, 'index.html'));

// What is in the bundle, with its licence.
const { packages } = JSON.parse(readFileSync(join(source, 'package-lock.json'), 'utf8'));
const licences = Object.entries(packages)
  .filter(([path, { dev }]) => path !== '' && !dev)
  .map(([path, { version }]) => {
    const name = path.replace('node_modules/', '');
    const file = readdirSync(join(modules, name)).find((entry) => entry.startsWith('LICENSE'));
    return `${name} ${version}\n\n${readFileSync(join(modules, name, file), 'utf8')}`;
  });
writeFileSync(join(out, 'licenses.txt'), licences.join('\n' + '-'.repeat(80) + '\n\n'));
