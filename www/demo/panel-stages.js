/** One row per stage: how far it is, how long it has taken; afterwards where the time went. @module */

import { byId, h } from './dom.js';
import { seconds } from './words.js';

/** @typedef {import('./stage-clock.js').StageClock} StageClock */

/**
 * @param {StageClock} job
 * @param {'running' | 'done' | 'stopped'} state
 */
export function showStages(job, state) {
  const list = byId('stage-list');
  while (list.children.length > job.stages.length) list.lastElementChild?.remove();
  while (list.children.length < job.stages.length) list.append(stageRow());
  const now = performance.now();
  const longest = Math.max(1, ...job.stages.map((stage) => stage.ms));
  job.stages.forEach((stage, k) => {
    const [name, bar, time] = /** @type {HTMLElement[]} */ ([...list.children[k].children]);
    const underWay = state === 'running' && stage === job.current;
    const ms = stage.ms + (underWay ? now - job.markedAt : 0);
    const through = stage.total > 0 ? stage.done / stage.total : 0;
    name.textContent = stage.name;
    // After the run the bars compare the stages' times instead.
    bar.style.setProperty('--share', String(state === 'done' ? stage.ms / longest : through));
    time.textContent = ms > 0 ? seconds(ms) : '–';
    list.children[k].className = `stage-row ${underWay ? 'is-current' : ''} ${stage.total > 0 && through >= 1 ? 'is-through' : ''}`;
  });
  const live = state === 'running' ? now - job.markedAt : 0;
  byId('stage-total').textContent = seconds(job.ms + live);
}

/** @returns {HTMLElement} */
function stageRow() {
  return h('li', { class: 'stage-row' }, h('span', { class: 'stage-name' }), h('span', { class: 'bar' }), h('span', { class: 'stage-time' }));
}
