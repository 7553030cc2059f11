// The package as the page takes it: all of its entries as one.

export * from 'tracecut';
export * from 'tracecut/draw';
export * from 'tracecut/edit';
export * from 'tracecut/export';
export * from 'tracecut/stages';
