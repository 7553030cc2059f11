// The bill of materials of the npm package, as CycloneDX 1.6 has it.

/**
 * @typedef {object} Part
 * @property {string} purl its identifier among all registries
 * @property {string} name
 * @property {string} version
 * @property {string} licence what it offers, as an SPDX expression
 * @property {string} source where its source is
 * @property {{alg: string, content: string}[]} hashes of the archive that the lock file names
 * @property {import('./notices.mjs').Notice[]} notices the licences taken
 * @property {Set<string>} files of `dist/` that hold it
 * @property {Set<string>} uses identifiers of what it is built with
 */

/** A licence as the schema wants it: one by its identifier, several as an expression. */
const licenceOf = (expression) => (/\s/.test(expression) ? { expression } : { license: { id: expression } });

/**
 * @param {Record<string, any>} manifest the package's package.json
 * @param {Part[]} parts
 * @param {string[]} ours what our own code uses directly
 */
export function billOfMaterials(manifest, parts, ours) {
  const { name, version, description, license } = manifest;
  const purl = `pkg:npm/${name}@${version}`;
  const links = { vcs: manifest.repository.url, website: manifest.homepage, 'issue-tracker': manifest.bugs.url };
  return {
    $schema: 'http://cyclonedx.org/schema/bom-1.6.schema.json',
    bomFormat: 'CycloneDX',
    specVersion: '1.6',
    version: 1,
    metadata: {
      lifecycles: [{ phase: 'build' }],
      component: {
        type: 'library',
        'bom-ref': purl,
        name,
        version,
        description,
        licenses: [licenceOf(license)],
        purl,
        externalReferences: Object.entries(links).map(([type, url]) => ({ type, url })),
      },
    },
    components: parts.map(componentOf),
    dependencies: [
      { ref: purl, dependsOn: ours },
      ...parts.map((part) => ({ ref: part.purl, dependsOn: [...part.uses].sort() })),
    ],
  };
}

/** @param {Part} part */
function componentOf({ purl, name, version, licence, source, hashes, files }) {
  return {
    type: 'library',
    'bom-ref': purl,
    name,
    version,
    ...(hashes.length > 0 && { hashes }),
    licenses: [licenceOf(licence)],
    purl,
    ...(source && { externalReferences: [{ type: 'vcs', url: source }] }),
    properties: [...files].map((value) => ({ name: 'tracecut:file', value: `dist/${value}` })),
  };
}
