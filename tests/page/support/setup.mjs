// Where things are, for all tests of the page. From CMake: OMNI_BUILD (build tree), OMNI_PAGE_MODULES (npm packages of the
// page), OMNI_PAGE_TEST_MODULES (those of these tests). Run by hand: the release build's.
import { createRequire } from 'node:module';
import { existsSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

export const root = join(dirname(fileURLToPath(import.meta.url)), '../../..');
export const build = process.env.OMNI_BUILD ?? join(root, 'build/release');
const pageModules = process.env.OMNI_PAGE_MODULES ?? join(build, 'service/page/node_modules');
const testModules = process.env.OMNI_PAGE_TEST_MODULES ?? join(build, 'tests/page/node_modules');

export const fromPage = createRequire(join(pageModules, 'x'));
export const fromTests = createRequire(join(testModules, 'x'));

// A module of the page's sources, bundled for Node.
export async function load(path) {
  const { build: bundle } = fromPage('esbuild');
  const result = await bundle({
    entryPoints: [join(root, 'service/page/src', path)],
    bundle: true,
    format: 'esm',
    write: false,
    nodePaths: [pageModules],
    logLevel: 'silent',
  });
  return import('data:text/javascript;base64,' + Buffer.from(result.outputFiles[0].contents).toString('base64'));
}

export function chromiumPath() {
  return ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find((path) => existsSync(path));
}
