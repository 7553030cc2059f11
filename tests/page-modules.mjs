// Modules of the page in Node: where the page finds the package as it is served, they find it as it is built. Import them
// at run time, after this file.

import { register } from 'node:module';

const hook = `export const resolve = (name, context, next) =>
  next(name.startsWith('../dist/') && context.parentURL?.includes('/studio/') ? '../' + name : name, context);`;
register(`data:text/javascript,${encodeURIComponent(hook)}`);
