/** Keys of the page: whoever does something registers the key for it. panels/help.js lists them. @module */

/** @typedef {{act: () => unknown, when: () => boolean}} Action */

export class Keys {
  constructor() {
    /** @type {Map<string, Action>} */
    this.actions = new Map();
    /** Whether the focus got where it is by the keyboard: then the space bar belongs to the button that has it. */
    this.tabbed = false;
    addEventListener('pointerdown', () => (this.tabbed = false), true);
    addEventListener('keydown', (event) => this.press(event));
  }

  /**
   * @param {string} key as in `KeyboardEvent.key`, letters small; `Ctrl+z` with the control or the command key,
   *   `Shift+ArrowUp`,
   *   `Ctrl+Shift+z` with shift too
   * @param {() => unknown} act
   * @param {() => boolean} [when] else the key is left to the browser
   */
  on(key, act, when = () => true) {
    this.actions.set(key, { act, when });
  }

  /**
   * @param {string} key
   * @returns {Action | undefined}
   */
  actionOf(key) {
    const action = this.actions.get(key);
    return action?.when() ? action : undefined;
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    const { key } = event;
    if (key === 'Tab') this.tabbed = true;
    if (event.ctrlKey || event.metaKey) {
      const shift = event.shiftKey ? 'Shift+' : '';
      return this.perform(event, this.actionOf(`Ctrl+${shift}${key.toLowerCase()}`));
    }
    if (event.altKey || document.querySelector('dialog[open]') || keepsKey(event, this.tabbed)) return;
    const held = event.shiftKey ? this.actionOf(`Shift+${key}`) : undefined;
    const action = held ?? this.actionOf(key) ?? this.actionOf(key.toLowerCase());
    // A button that was clicked with the mouse would still answer to the space bar.
    if (action && key === ' ') /** @type {HTMLElement} */ (event.target).blur();
    this.perform(event, action);
  }

  /**
   * @param {KeyboardEvent} event
   * @param {Action | undefined} action
   */
  perform(event, action) {
    if (!action) return;
    event.preventDefault();
    action.act();
  }
}

/**
 * Form fields keep the keys that they use themselves, and so do buttons that were reached with the keyboard.
 *
 * @param {KeyboardEvent} event
 * @param {boolean} tabbed
 * @returns {boolean}
 */
function keepsKey(event, tabbed) {
  if (event.key === 'Escape') return false;
  const target = /** @type {HTMLElement} */ (event.target);
  if (target.matches('select, textarea, input[type="number"]')) return true;
  if (target.matches('input[type="range"]')) return /^(Arrow|Home|End|Page)/.test(event.key);
  return event.key === ' ' && tabbed && target.matches('button, input, a');
}
