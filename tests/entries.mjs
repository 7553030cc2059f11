// All entries of the package in Node, as one module.

export * from 'tracecut';
export * from 'tracecut/draw';
export * from 'tracecut/edit';
export * from 'tracecut/export';
export * from 'tracecut/stages';
