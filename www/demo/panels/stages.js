/** One row per stage: how far it is, how long it has taken; afterwards where the time went. @module */

import { addBlock, h } from '../dom.js';
import { seconds } from '../words.js';
import { say } from '../language.js';

/** @typedef {import('../run/stage-clock.js').StageClock} StageClock */

/**
 * @typedef {{name: string, bar: number, ms: number, underWay: boolean, through: boolean}} StageRow `bar` in 0..1
 */

/**
 * @param {StageClock} clock
 * @param {'running' | 'done' | 'stopped'} how
 * @returns {{rows: StageRow[], ms: number}} the stages as they are now
 */
export function stagesOf(clock, how) {
  const live = how === 'running' ? performance.now() - clock.markedAt : 0;
  const longest = Math.max(1, ...clock.stages.map((stage) => stage.ms));
  const rows = clock.stages.map((stage) => {
    const underWay = how === 'running' && stage === clock.current;
    const part = stage.total > 0 ? stage.done / stage.total : 0;
    return {
      name: stage.name,
      // After the run the bars compare the stages' times instead.
      bar: how === 'done' ? stage.ms / longest : part,
      ms: stage.ms + (underWay ? live : 0),
      underWay,
      through: stage.total > 0 && part >= 1,
    };
  });
  return { rows, ms: clock.ms + live };
}

/** @param {Pick<import('./panels.js').Page, 'store'>} page */
export function stagesPanel({ store }) {
  const list = h('ol', { id: 'stage-list', class: 'stages' });
  const total = h('p', { id: 'stage-total', class: 'block-note' });
  addBlock('stages', 'Time by stage', total, list);
  /** @type {ReturnType<typeof stageRow>[]} */
  let shown = [];
  store.watch(['stages'], ({ stages: { rows, ms } }) => {
    if (shown.length !== rows.length) {
      shown = rows.map(stageRow);
      list.replaceChildren(...shown.map(({ element }) => element));
    }
    rows.forEach((row, k) => shown[k].show(row));
    total.textContent = rows.length > 0 ? seconds(ms) : '';
  });
}

function stageRow() {
  const name = h('span', { class: 'stage-name' });
  const bar = h('span', { class: 'bar' });
  const time = h('span', { class: 'stage-time' });
  const element = h('li', { class: 'stage-row' }, name, bar, time);
  /** @param {StageRow} row */
  const show = (row) => {
    name.textContent = say(row.name);
    bar.style.setProperty('--share', String(row.bar));
    time.textContent = row.ms > 0 ? seconds(row.ms) : '–';
    element.className = `stage-row ${row.underWay ? 'is-current' : ''} ${row.through ? 'is-through' : ''}`;
  };
  return { element, show };
}
