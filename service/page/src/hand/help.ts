// What the hand and the view take, for the help panel and for screen readers.
export const kLabelHand =
  'The pen over the base. Arrow keys move it left, right, away and towards you; Page Up and Page Down move it up and ' +
  'down; Shift makes small steps; W, A, S, D tilt it; Home puts it back to the start; Delete takes it away; Enter ' +
  'reports where it is and what it touches.';
export const kLabelView =
  'The pen over the base. Arrow keys turn the view; plus and minus zoom; Enter reports where the pen is and what it ' +
  'touches.';

export const kHelp: readonly { keys: string; does: string }[] = [
  { keys: 'Click, if there is no pen', does: 'put the pen above the scene' },
  { keys: 'Drag the pen', does: 'move it up, down and sideways; it follows like on a spring' },
  { keys: 'Shift + drag the pen, or scroll on it', does: 'move it away from you and towards you' },
  { keys: 'Ctrl + drag the pen', does: 'tilt it' },
  { keys: 'Touch: a second finger while you hold the pen', does: 'apart: towards you; together: away from you' },
  { keys: '← → ↑ ↓', does: 'move the pen left, right, away from you, towards you' },
  { keys: 'Page Up, Page Down or R, F', does: 'move it up, down' },
  { keys: 'W, S, A, D', does: 'tilt it away from you, towards you, left, right' },
  { keys: 'Shift + these keys', does: 'small steps: 0.2 mm instead of 1 mm' },
  { keys: 'Home', does: 'back to the start' },
  { keys: 'Delete or Backspace', does: 'take the pen away' },
  { keys: 'Drag beside the pen, or right drag', does: 'turn the view' },
  { keys: 'Scroll beside the pen or Ctrl + scroll', does: 'zoom' },
  { keys: 'Touch: two fingers', does: 'turn the view and zoom' },
  { keys: 'Middle drag or Shift + right drag', does: 'shift the view' },
  { keys: 'Ctrl + ← → ↑ ↓', does: 'turn the view (without the hand: also without Ctrl)' },
  { keys: '+ −', does: 'zoom' },
  { keys: 'Enter', does: 'say where the pen is, what it touches and how hard' },
];
