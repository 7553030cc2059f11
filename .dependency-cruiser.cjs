// The import rules of ARCHITECTURE.md. They are checked over the compiled files, where imports of types are gone: `dist` is
// `npm`, `build` is `studio`.

/** @type {import('dependency-cruiser').IConfiguration} */
module.exports = {
  forbidden: [
    { name: 'no circles', severity: 'error', from: {}, to: { circular: true } },
    { name: 'every import leads to a file', severity: 'error', from: {}, to: { couldNotResolve: true } },
    {
      name: 'the package imports only itself',
      severity: 'error',
      from: { path: '^dist/' },
      to: { pathNot: '^dist/', dependencyTypesNot: ['core'] },
    },
    {
      name: 'only the entries for Node import its modules',
      severity: 'error',
      from: { path: '^dist/', pathNot: '^dist/node/' },
      to: { dependencyTypes: ['core'] },
    },
    {
      name: 'the model of the studio imports nothing of the view',
      severity: 'error',
      from: { path: '^build/model/' },
      to: { path: '^build/view/' },
    },
    {
      name: 'the studio imports the package through model/library',
      severity: 'error',
      from: { path: '^(build|studio)/', pathNot: '^build/model/library\\.js$' },
      to: { path: '^dist/', pathNot: '^dist/(node/)?selftest\\.js$' },
    },
    {
      name: 'the studio imports only itself and the package',
      severity: 'error',
      from: { path: '^(build|studio)/' },
      to: { pathNot: '^(build|studio|dist)/|node_modules/fflate/' },
    },
    {
      name: 'the lab imports public entries of the package',
      severity: 'error',
      from: { path: '^www/' },
      to: { pathNot: '^www/|^dist/(node/)?(index|draw|edit|export|stages)\\.js$' },
    },
    {
      name: 'scripts import neither the studio nor the lab',
      severity: 'error',
      from: { path: '^scripts/' },
      to: { path: '^(build|studio|www)/' },
    },
  ],
  options: {
    doNotFollow: { path: 'node_modules' },
    // The first import what a bundler adds, and the others contain it.
    exclude: { path: '^(scripts/bundle/|dist/(inline|worker\\.bundle)\\.js$|dist/node/\\w+\\.cjs$)' },
    enhancedResolveOptions: {
      exportsFields: ['exports'],
      conditionNames: ['import', 'node', 'default'],
    },
  },
};
