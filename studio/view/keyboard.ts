// Keyboard shortcuts. Panels register their keys; panels/help.ts lists them.

type Action = { act: () => unknown; when: () => boolean };

export class Keys {
  actions = new Map<string, Action[]>();
  /** True if the focus was moved by the keyboard; then keys act on the focused button. */
  tabbed = false;

  constructor() {
    addEventListener('pointerdown', () => (this.tabbed = false), true);
    addEventListener('keydown', (event) => this.press(event));
  }

  /**
   * @param key as in `KeyboardEvent.key`, letters small; `Ctrl+z` with the control or the command key,
   * `Shift+ArrowUp`, `Ctrl+Shift+z` with shift too
   * @param when returns false to leave the key to the action registered before, or to the browser
   */
  on(key: string, act: () => unknown, when: () => boolean = () => true) {
    this.actions.set(key, [{ act, when }, ...(this.actions.get(key) ?? [])]);
  }

  actionOf(key: string): Action | undefined {
    return this.actions.get(key)?.find(({ when }) => when());
  }

  press(event: KeyboardEvent) {
    const { key } = event;
    if (key === 'Tab') this.tabbed = true;
    if (event.ctrlKey || event.metaKey) {
      const shift = event.shiftKey ? 'Shift+' : '';
      return this.perform(event, this.actionOf(`Ctrl+${shift}${key.toLowerCase()}`));
    }
    if (event.altKey || document.querySelector('dialog[open]') || usesKey(event, this.tabbed)) return;
    const shiftAction = event.shiftKey ? this.actionOf(`Shift+${key}`) : undefined;
    const action = shiftAction ?? this.actionOf(key) ?? this.actionOf(key.toLowerCase());
    // A button clicked with the mouse would still react to the space bar.
    if (action && key === ' ') (event.target as HTMLElement).blur();
    this.perform(event, action);
  }

  perform(event: KeyboardEvent, action: Action | undefined) {
    if (!action) return;
    event.preventDefault();
    action.act();
  }
}

/** Returns whether the focused element uses the key itself: form fields, and buttons focused by keyboard. */
function usesKey(event: KeyboardEvent, tabbed: boolean): boolean {
  if (event.key === 'Escape') return false;
  const target = event.target as HTMLElement;
  if (target.matches('select, textarea, input[type="number"]')) return true;
  if (target.matches('input[type="range"]')) return /^(Arrow|Home|End|Page)/.test(event.key);
  if (target.matches('input[type="radio"]') && event.key.startsWith('Arrow')) return tabbed;
  return event.key === ' ' && tabbed && target.matches('button, input, a');
}
